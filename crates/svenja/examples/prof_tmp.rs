use bullet::*;
use svenja::*;
fn main() {
    let m = Morphology::open(std::path::Path::new("models/svenja.toml")).unwrap();
    let mut g: Vec<_> = (0..16)
        .map(|_| {
            let mut w = World::new(&WorldSettings::default()).unwrap();
            add_ground(&mut w).unwrap();
            let r = Robot::spawn(&m, &mut w).unwrap();
            (w, r)
        })
        .collect();
    let mut l = Lockstep::new().unwrap();
    let mut res = Vec::new();
    let mut x = 1u64;
    for s in 0..6000 {
        for (w, r) in &mut g {
            if s % 10 == 0 {
                let t: Vec<f64> = (0..r.n_actuators())
                    .map(|_| {
                        x = x.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                        if x >> 63 == 1 { 1.0 } else { -1.0 }
                    })
                    .collect();
                r.actuate(&t).unwrap();
            }
            r.drive(w).unwrap();
        }
        let mut ws: Vec<&mut World> = g.iter_mut().map(|p| &mut p.0).collect();
        l.step(&mut ws, &mut res).unwrap();
    }
    let t = l.times();
    let n = 6000. * 16. / 1e6;
    println!(
        "begin {:.1} pack {:.1} sweep {:.1} unpack {:.1} end {:.1} {:?}",
        t.begin / n,
        t.pack / n,
        t.sweep / n,
        t.unpack / n,
        t.end / n,
        l.counts()
    );
}
