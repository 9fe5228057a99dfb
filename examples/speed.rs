use column_twin::column::*;
fn main(){
    let impact=Impact{mass:1500.0,velocity:10.0,gap:0.0,restitution:0.0};
    for (a,b) in [(2.0,2.0),(1.0,1.3)]{ for scheme in [Scheme::Midpoint,Scheme::Energy]{
        let p=ColumnProperties{length_below:1.0,length_above:3.0,axial_rigidity:210e9*91e-4,bending_stiffness:210e9*8091e-8,mass_per_length:70.1,
    resistance_moment:0.307e6,resistance_axial:3.23e6,yield_surface:YieldExponents{alpha:a,beta:b,gamma:1.0},elastic_law:ElasticLaw::Uncoupled,base:Support::BuiltIn,top:Support::BuiltIn,
    hinge_stiffness:[None;4],top_spring_stiffness:1e7,top_mass:0.0,top_load:5e5,damping_ratio:0.0,scheme,step_nanos:10_000};
        let m=Model::new(&p).unwrap();
        let mut best=f64::MAX;
        for _ in 0..20 { let mut s=State::at_rest(&m); s.begin_impact(&m,impact).unwrap();
        let t=std::time::Instant::now(); for _ in 0..6000 { step(&m,&mut s).unwrap(); } best=best.min(t.elapsed().as_secs_f64()/6000.0); std::hint::black_box(&s);}
        let mut s=State::at_rest(&m); s.begin_impact(&m,impact).unwrap(); for _ in 0..6000 { step(&m,&mut s).unwrap(); } println!("{a} {b} {scheme:?}: {:.3} us/step, {:.3} corr/step", best*1e6, s.corrections as f64/6000.0);
    }}
}
