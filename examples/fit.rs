use column_twin::parameters::*;
use column_twin::senses::*;
use std::path::Path;
use std::time::Instant;
struct Rng(u64);
impl Rng {
    fn uniform(&mut self) -> f64 { self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15); let mut z = self.0; z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9); z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB); ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 }
    fn normal(&mut self) -> f64 { let u = self.uniform().max(1e-300); (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos() }
}
fn main() {
    let sets: [(&str, &[usize]); 6] = [("all", &[0, 1, 2, 3, 4, 5, 6, 7]), ("disp", &[3]), ("strain", &[4, 5]), ("accel", &[0, 1, 2]), ("accdisp", &[1, 3]), ("ads", &[1, 3, 4])];
    let cases = [("s01_rigid_3", 0.8, 1500.0, 3.0, 9.972e-3, 6.228e-3), ("s02_rigid_10", 0.8, 1500.0, 10.0, 84.01e-3, 79.04e-3), ("s04_car_soft_14", 0.8, 1500.0, 14.0, 1.56e-3, 0.0), ("s06_truck8_8", 1.25, 8000.0, 8.0, 98.99e-3, 90.79e-3), ("s13_van_soft_5", 0.8, 2000.0, 5.0, 0.64e-3, 0.0)];
    let arg = std::env::args().nth(1).unwrap_or("all".into());
    let only = std::env::args().nth(2).unwrap_or("s".into());
    let seed: u64 = std::env::args().nth(3).map_or(7, |x| x.parse().unwrap());
    for (set, chosen) in sets.iter().filter(|s| s.0 == arg || arg == "each") {
        for (name, la, mass, v, peak, residual) in cases.iter().filter(|c| c.0.contains(&only)) {
            let (la, mass, v) = (*la, *mass, *v);
            let ov: Vec<String> = vec![format!("geometry.length_below:={la:?}"), format!("geometry.length_above:={:?}", 4.0 - la), "rate.law:=none".into()];
            let ov: Vec<_> = ov.iter().map(|t| parse_override(t)).collect();
            let p = Parameters::load(&[Path::new("config/heb220_s355.yaml").to_path_buf()], &ov).unwrap();
            let s = |q, h: f64, range: f64, noise: f64, fibre: f64| Sensor { name: String::new(), quantity: q, height: h, range, noise, bias: 0.0, gain_error: 0.01, rate: 1e4, bandwidth: 0.0, reversed: false, fibre };
            let g = 9.81;
            let all = [s(Quantity::Acceleration, 1.0, 50.0 * g, 0.0022 * g, 0.0), s(Quantity::Acceleration, la, 50.0 * g, 0.0022 * g, 0.0), s(Quantity::Acceleration, 3.0, 50.0 * g, 0.0022 * g, 0.0),
                s(Quantity::Displacement, la, 0.0, 1e-4, 0.0), s(Quantity::BendingStrain, 0.022, 0.0, 1e-6, 0.11), s(Quantity::BendingStrain, 2.0, 0.0, 1e-6, 0.11), s(Quantity::AxialStrain, 0.1, 0.0, 1e-6, 0.0), s(Quantity::AxialStrain, 2.0, 0.0, 1e-6, 0.0)];
            let sensors: Vec<Sensor> = chosen.iter().map(|&i| all[i].clone()).collect();
            let data: Vec<Vec<f64>> = csv::Reader::from_path(format!("/root/sig/{name}.csv")).unwrap().records().map(|r| r.unwrap().iter().skip(1).map(|x| x.parse().unwrap()).collect()).collect();
            let mut rng = Rng(seed);
            let bias: Vec<f64> = (0..8).map(|i| if i < 3 { 0.05 * g * rng.normal() } else { 0.0 }).collect();
            let gain: Vec<f64> = (0..8).map(|_| 1.0 + 0.01 * rng.normal()).collect();
            let noisy: Vec<Vec<f64>> = data.iter().map(|r| r.iter().enumerate().map(|(i, x)| { let y = x * gain[i] + bias[i] + all[i].noise * rng.normal(); if all[i].range > 0.0 { y.clamp(-all[i].range, all[i].range) } else { y } }).collect()).collect();
            let mut detector = Detector::new(&sensors);
            let mut found = None;
            'search: for (i, row) in noisy.iter().enumerate() {
                for (k, &c) in chosen.iter().enumerate() {
                    if let Some(d) = detector.push(k, i as f64 * 1e-4, row[c]) { found = Some(d); break 'search; }
                }
            }
            let Some(found) = found else { println!("{set} {name}: not detected"); continue };
            let t = Instant::now();
            let mut e = Estimator::new(&p, sensors, hypotheses(&p), 1).unwrap();
            while !e.prepare() {}
            println!("{set} {name}: contact {:.2} ms dev {:.2} confirmed {:.1} by {}; bank {} in {:.1} s; truth m {mass} v {v} p {:.0} peak {:.2} residual {:.2}", (found.contact.time - 0.05) * 1e3, found.contact.deviation * 1e3, (found.confirmed_at - 0.05) * 1e3, found.sensor, e.responses(), t.elapsed().as_secs_f64(), mass * v, peak * 1e3, residual * 1e3);
            e.begin(found.contact.time, found.contact.deviation, &found.zeros);
            for (i, row) in noisy.iter().enumerate() { for (k, &c) in chosen.iter().enumerate() { e.push(k, i as f64 * 1e-4, row[c]); } }
            for until in UPDATE_INSTANTS.into_iter().filter(|u| ![0.015, 0.03, 0.075, 0.25].contains(u)) {
                let t = Instant::now();
                e.observe(found.contact.time + until);
                let observed = t.elapsed().as_secs_f64() * 1e3;
                e.settle(20);
                let r = e.estimate(found.contact.time + until);
                print!("  {:3.0} ms ess {:5.1} sims {}", until * 1e3, r.effective_responses, e.responses());
                let show = |n: &str, x: CredibleInterval, k: f64, truth: f64| print!(" {n} {:.4} [{:.4} {:.4}]{}", x.mean * k, x.low * k, x.high * k, if (x.low * k..=x.high * k).contains(&truth) { "" } else { "!" });
                show("m", r.mass, 1.0, mass); show("v", r.velocity, 1.0, v); show("mv", r.momentum, 1.0, mass * v); show("peak", r.peak_v1, 1e3, peak * 1e3); show("res", r.residual_v1, 1e3, residual * 1e3);
                show("t", r.contact_time, 1e3, 50.0);
                print!(" cap {:.3} [{:.3} {:.3}] {:?}", r.capacity_ratio.mean, r.capacity_ratio.low, r.capacity_ratio.high, r.severity.iter().map(|x| (x.1 * 100.0).round()).collect::<Vec<_>>()); println!(" | {} {:.2} {} {:.2} | {:.0} {:.0} ms", r.vehicle_probabilities[0].0, r.vehicle_probabilities[0].1, r.vehicle_probabilities[1].0, r.vehicle_probabilities[1].1, observed, t.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
}
