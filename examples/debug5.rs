use column_twin::column::*;
fn main(){
    let j:serde_json::Value=serde_json::Deserializer::from_str(&std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap()).into_iter::<serde_json::Value>().next().unwrap().unwrap();
    let p:ColumnProperties=serde_json::from_value(j["column"].clone()).unwrap(); let i:Impact=serde_json::from_value(j["impact"].clone()).unwrap();
    let m=Model::new(&p).unwrap(); let mut s=State::at_rest(&m); let mut r=Response::begin(&m,&mut s,i,1.0).unwrap();
    loop { match r.advance(&m,&mut s,u64::MAX) {Ok(Progress::Running)=>{let q=s.sample(&m);println!("S {} {:?} v {} u1 {} u2 {} N {} {} M {} {} {} {} rates {} {} {} LED {:e} W {:e} perc {}",q.time,q.phase,q.v1,q.u1,q.u2,q.hinges[0].normal_force,q.hinges[1].normal_force,q.hinges[0].moment,q.hinges[1].moment,q.hinges[2].moment,q.hinges[3].moment,q.v1_rate,q.u1_rate,q.u2_rate,q.ledger_residual,q.plastic_work,s.percussions)}, x=>{println!("{x:?}"); break;}} }
    debug_curve(&m,&s,m.step_secs/4096.0);
}
