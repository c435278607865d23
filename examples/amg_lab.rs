use fracas::contact::JumpStabilization;
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::Silent;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::*;
use std::time::Instant;
struct Scaled(Box<dyn Preconditioner<f64>>, f64);
impl Preconditioner<f64> for Scaled {
    fn size(&self) -> usize { self.0.size() }
    fn solve(&self, r: &[f64], z: &mut [f64], w: &mut [f64]) { self.0.solve(r, z, w); for v in z.iter_mut() { *v *= self.1 } }
    fn work_len(&self) -> usize { self.0.work_len() }
    fn flops(&self) -> u64 { self.0.flops() }
    fn is_linear(&self) -> bool { self.0.is_linear() }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = &args[1];
    let mut over: Vec<&str> = vec![];
    let mut settings: Vec<String> = vec![];
    let mut aug = "local_h".to_string();
    for a in &args[2..] { if a.starts_with('{') { settings.push(a.clone()) } else if let Some(x)=a.strip_prefix("aug=") { aug = x.into() } else { over.push(a) } }
    if settings.is_empty() { settings.push("{}".into()) }
    let scene = if scene.ends_with(".toml") { fracas::scene::Scene::from_toml(&std::fs::read_to_string(scene).unwrap(), scene).unwrap() } else { fracas::scene::named(scene).unwrap().scene().unwrap() };
    let scene = scene.with_overrides(&over).unwrap();
    let t = Instant::now();
    let blocks = scene.build().unwrap().saddle_blocks(Some(JumpStabilization::default())).unwrap();
    let unit = blocks.traction_unit();
    let blocks = blocks.in_traction_unit(unit);
    println!("n_u {} n_t {} built {:.2}", blocks.n_u(), blocks.n_t(), t.elapsed().as_secs_f64());
    let t = Instant::now();
    let c = aug.parse::<AugmentationChoice>().unwrap().compute(&blocks, DirectChoice::Auto.solver().unwrap().as_ref()).unwrap().matrix;
    println!("C {:.3} s", t.elapsed().as_secs_f64());
    let op = SaddleOperator::new(&blocks);
    for s in &settings {
        let inner: InnerChoice = if s.contains("exact") { InnerChoice::default() } else { InnerChoice::Amg(serde_json::from_str(s).unwrap()) };
        let t = Instant::now();
        let ready = inner.prepare(&blocks, &c).unwrap();
        let setup = t.elapsed().as_secs_f64();
        println!("--- {s}  setup {setup:.3}");
        if std::env::var("V").is_ok() { if let Some(h) = &ready.hierarchy { println!("{h}"); } }
        let w: f64 = std::env::var("W").ok().map_or(1.0, |w| w.parse().unwrap());
        let racp = RacpInverse::new(blocks.b1.clone(), c.clone(), Scaled(ready.inverse, w));
        let c_app = racp.flops() as f64 / op.flops() as f64;
        for (name, b) in [("phys", blocks.rhs()), ("sin", (1..=blocks.size()).map(|i| (i as f64).sin()).collect())] {
          for k in std::env::var("K").unwrap_or("gmres".into()).split(',') {
            let k: KrylovChoice = k.parse().unwrap();
            let sys = System { operator: &op, preconditioner: &racp, rhs: &b };
            let mut x = vec![0.0; b.len()];
            let t = Instant::now();
            let r = k.flexible_for(&racp).method().solve(&sys, &Criteria { relative_tolerance: 1e-8, max_iterations: 600 }, &mut x, &mut Silent);
            let dt = t.elapsed().as_secs_f64();
            match r { Ok(r) => println!("{name:5} {k} it {} res {:.1e} {:?} solve {dt:.3} s  c_app {c_app:.2} C_s {:.0}", r.iterations, r.relative_residual, r.outcome, r.iterations as f64*(1.0+c_app)),
              Err(e) => println!("{name} {k} {e} {dt:.3}") }
          }
        }
    }
}
