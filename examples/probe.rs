use column_twin::column::*;
fn paper(alpha:f64,beta:f64,scheme:Scheme,dt:u64)->ColumnProperties{
    ColumnProperties{length_below:1.0,length_above:3.0,axial_rigidity:210e9*91e-4,bending_stiffness:210e9*8091e-8,mass_per_length:70.1,
    resistance_moment:0.307e6,resistance_axial:3.23e6,yield_surface:YieldExponents{alpha,beta,gamma:1.0},elastic_law:ElasticLaw::Uncoupled,base:Support::BuiltIn,top:Support::BuiltIn,
    hinge_stiffness:[None;4],top_spring_stiffness:1e7,top_mass:0.0,top_load:5e5,damping_ratio:0.0,scheme,step_nanos:dt}
}
fn main(){
    let impact=Impact{mass:1500.0,velocity:10.0,gap:0.0,restitution:0.0};
    for (a,b,vref,pw,rel) in [(2.0,2.0,0.09460223661484371,71059.33492666167,0.0248765),(1.0,1.3,0.09866496749562503,75763.84145796228,0.02549)]{
      for scheme in [Scheme::Midpoint,Scheme::Energy]{
        for dt in [100_000,50_000,20_000,10_000]{
            let t=std::time::Instant::now();
            let mut ns=vec![]; let mut zig=0.0f64; let mut gap=0.0f64; let mut worst_u=0.0f64;
            let p=paper(a,b,scheme,dt);
            let r=match simulate(&p,&impact,2.0,&mut |s|{ns.push(s.hinges[0].normal_force); let k=ns.len(); if k>2 {zig=zig.max((ns[k-1]-2.0*ns[k-2]+ns[k-3]).abs()/4.0/3.23e6);} if s.phase==Phase::Contact {gap=gap.max(s.gap.abs());} for h in s.hinges {worst_u=worst_u.max(h.utilisation-1.0);} }) {Ok(r)=>r,Err(e)=>{println!("{a} {b} {scheme:?} {dt}: {e}");continue}};
            let el=t.elapsed();
            println!("{a} {b} {scheme:?} {dt:6}: v {:+.3e} tv {:.4}ms pw {:+.2e} rel {:+.2e}s vc {:.5} led {:.1e} zig {:.1e} gap {:.1e} U {:.1e} Fmax {:.2} steps {} end {:.4} res {:?} perc {} {:.1?} {:.2}us",
              r.max_v1/vref-1.0,r.max_v1_time*1e3,r.plastic_work/pw-1.0,r.release_time.unwrap_or(f64::NAN)-rel,r.impactor_velocity,r.ledger_residual,zig,gap,worst_u,r.peak_contact_force/1e3,r.steps,r.end_time,r.residual_v1,r.percussions,el,el.as_secs_f64()*1e6/r.steps as f64);
            if dt==20_000 {println!("   yields {:?} loss {} imp {}", r.hinges.map(|h|h.first_yield.map(|t|(t*1e6).round()/1e3)), r.impact_loss, r.impulse);}
        }}}
}
