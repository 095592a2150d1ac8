use glam::{DAffine3, DVec3};
use std::time::Instant;
use vcsg::math::Aabb;
use vcsg::voxelize::{Primitive, Profile, Solid, beams::Voxelizer};
fn main() {
    let cases = [
        (
            "sphere",
            Solid::Sphere {
                center: DVec3::ZERO,
                radius: 32.0,
            },
        ),
        ("cone", Solid::revolved(Profile::frustum(32.0, 0.0, 64.0))),
        (
            "box",
            Solid::Box(Aabb::new(-DVec3::new(16., 32., 16.), DVec3::new(16., 32., 16.))),
        ),
        ("cylinder", Solid::revolved(Profile::cylinder(32., 64.))),
        ("torus", Solid::revolved(Profile::torus(32., 10.))),
    ];
    let reps: usize = std::env::args().nth(2).map_or(60, |a| a.parse().unwrap());
    let only = std::env::args().nth(1);
    for (n, s) in cases {
        if only.as_deref().is_some_and(|o| o != n) {
            continue;
        }
        for hollow in [false, true] {
            let mut p = Primitive::soft(s.clone(), 1.0);
            if hollow {
                p = p.shell(1.0).unwrap();
            }
            let dims = [80, 80, 80];
            let wl = DAffine3::from_translation(DVec3::splat(-39.5));
            let mut best = [f64::MAX; 3];
            let mut c = (0, 0);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            pool.install(|| {
                for _ in 0..reps {
                    let placed = p.placed(&DAffine3::IDENTITY, 1.0);
                    let v = Voxelizer::new(&placed, dims, &wl);
                    let t = Instant::now();
                    let d = v.depths();
                    let a = t.elapsed().as_secs_f64();
                    let t = Instant::now();
                    let r = d.runs(dims[2]);
                    let b = t.elapsed().as_secs_f64();
                    let t = Instant::now();
                    let f = v.fill(&r);
                    let e = t.elapsed().as_secs_f64();
                    c = (r.soft.iter().flatten().map(|r| r.voxels.len()).sum::<usize>(), f.len());
                    for (i, x) in [a, b, e].into_iter().enumerate() {
                        best[i] = best[i].min(x);
                    }
                }
            });
            println!(
                "{n} hollow={hollow} depths {:.2} runs {:.2} fill {:.2} ms soft {}",
                best[0] * 1e3,
                best[1] * 1e3,
                best[2] * 1e3,
                c.0
            );
        }
    }
}
