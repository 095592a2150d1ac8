//! What lies behind closed tiles alone is passed over, and nothing else; slabs of depth take each plane once.

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use vcsg::interface::OPEN_TILE;
use vcsg::math::{Aabb, affine};
use vcsg::model::Boundary;
use vcsg::projection::bands::Sweep;
use vcsg::projection::{BoxView, Camera, OpenTiles, Planes, Remaining, eye_from_lattice};
use vcsg::target::{Lattice, Target};

use crate::support::scenes::{scene, subdivision};
use crate::support::views::eye;
use crate::support::{cases, seeded};

/// Tiles of a frame, open or not.
#[derive(Clone, Debug)]
struct Tiles {
    size: [u32; 2],
    /// Taken again and again, row by row.
    open: Vec<bool>,
}

impl Tiles {
    fn of(size: [u32; 2], open: &[bool]) -> Self {
        Self {
            size,
            open: open.to_vec(),
        }
    }

    fn across(&self) -> usize {
        OpenTiles::dims(self.size)[0] as usize
    }

    fn is_open(&self, tile: usize) -> bool {
        self.open[tile % self.open.len()]
    }

    fn counted(&self) -> OpenTiles {
        OpenTiles::new(self.size, |tile| self.is_open(tile))
    }

    /// Whether the tile of a place in the frame is open; `None` outside.
    fn at(&self, px: DVec2) -> Option<bool> {
        let size = DVec2::from(self.size.map(f64::from));
        let inside = px.cmpge(DVec2::ZERO).all() && px.cmplt(size).all();
        let tile = (px / f64::from(OPEN_TILE)).floor();
        inside.then(|| self.is_open(tile.y as usize * self.across() + tile.x as usize))
    }
}

fn open() -> impl Strategy<Value = Vec<bool>> {
    // Mostly closed, in a row whose length no frame's has in common.
    prop::collection::vec(prop::bool::weighted(0.2), 1..97)
}

fn fraction() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(0.0f64..1.0).prop_map(DVec3::from)
}

/// A box of a lattice that may reach beyond it, and points in it.
#[derive(Clone, Debug)]
struct Asked {
    corner: DVec3,
    size: DVec3,
    points: Vec<DVec3>,
}

fn asked() -> impl Strategy<Value = Asked> {
    let points = prop::collection::vec(fraction(), 40);
    (fraction(), fraction(), points).prop_map(|(corner, size, points)| Asked { corner, size, points })
}

impl Asked {
    fn bounds(&self, lattice: &Lattice) -> Aabb {
        let all = lattice.bounds();
        let corner = all.min + all.size() * self.corner;
        Aabb::new(corner, corner + 0.3 * all.size() * self.size)
    }
}

/// A point of the box that an open tile sees between two depths, if there is one.
fn shown(asked: &Asked, lattice: &Lattice, camera: &Camera, tiles: &Tiles, depths_mm: [f64; 2]) -> Option<DVec3> {
    let bounds = asked.bounds(lattice);
    let eye_from_lattice = eye_from_lattice(lattice, camera);
    let shows = |eye: &DVec3| {
        let [near, far] = depths_mm;
        (near..far).contains(&eye.z) && eye.z > camera.near_mm() && tiles.at(camera.project(*eye)) == Some(true)
    };
    let points = asked.points.iter().map(|f| bounds.min + bounds.size() * *f);
    points.map(|p| affine::point(&eye_from_lattice, p)).find(shows)
}

/// Whether `asked` is found to remain, and whether it must be.
fn found(
    target: &Target,
    camera: &Camera,
    asked: &Asked,
    tiles: &Tiles,
    counted: &OpenTiles,
    part: [f64; 2],
) -> [bool; 2] {
    let lattice = &target.lattice;
    let view = BoxView::new(lattice, camera);
    let eye = view.eye_bounds(&lattice.bounds());
    let depths_mm = part.map(|f| eye.min.z + f * eye.size().z);
    let remaining = Remaining {
        view: &view,
        depths_mm,
        open: counted,
    };
    let must = shown(asked, lattice, camera, tiles, depths_mm).is_some();
    [remaining.may_show(&asked.bounds(lattice)), must]
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn open_tiles_are_counted(
        size in prop::array::uniform2(1u32..200),
        open in open(),
        ends in prop::array::uniform2(prop::array::uniform2(-40.0f64..240.0)),
    ) {
        let tiles = Tiles::of(size, &open);
        let [a, b] = ends.map(DVec2::from);
        let [least, greatest] = [a.min(b), a.max(b)];
        let [across, down] = OpenTiles::dims(size);
        let edge = f64::from(OPEN_TILE);
        let touched = |x: u32, y: u32| {
            let first = DVec2::new(f64::from(x), f64::from(y)) * edge;
            (first - 1.0 / 16.0).cmple(greatest).all() && (first + edge + 1.0 / 16.0).cmpgt(least).all()
        };
        let counted = (0..across * down)
            .filter(|n| touched(n % across, n / across) && tiles.is_open(*n as usize))
            .count();
        prop_assert_eq!(tiles.counted().within([least, greatest]) as usize, counted);
    }

    #[test]
    fn what_an_open_tile_sees_remains(
        scene in scene(),
        eye in eye(),
        open in open(),
        asked in asked(),
        part in (0.0f64..1.0, 0.0f64..1.0),
    ) {
        let target = scene.target(&seeded(&subdivision(Boundary::Exact), 1));
        let camera = eye.camera(&target.lattice.world_bounds());
        let tiles = Tiles::of(camera.size, &open);
        let part = [part.0.min(part.1), part.0.max(part.1)];
        let [remains, must] = found(&target, &camera, &asked, &tiles, &tiles.counted(), part);
        prop_assert!(remains || !must);
    }

    #[test]
    fn slabs_take_each_plane_once(scene in scene(), eye in eye(), opens in prop::collection::vec(open(), 1..9)) {
        let target = scene.target(&seeded(&subdivision(Boundary::Exact), 2));
        let camera = eye.camera(&target.lattice.world_bounds());
        let view = BoxView::new(&target.lattice, &camera);
        let planes = Planes::new(&target.lattice, &camera, 1.0);
        let eye = view.eye_bounds(&target.lattice.bounds());
        let all = planes.between(eye.min.z.max(camera.near_mm()), eye.max.z);
        let mut sweep = Sweep::new(&target.lattice, planes, &view);
        let mut next = all.start;
        let mut opens = opens.iter().cycle();
        loop {
            let open = opens.next().map_or(&[][..], |open| open);
            let tiles = Tiles::of(camera.size, open).counted();
            let Some(depths_mm) = sweep.next(&tiles) else {
                prop_assert!(next == all.end || tiles.within(view.seen_px(&eye)) == 0, "{next} of {all:?}");
                break;
            };
            let slab = planes.between(depths_mm[0], depths_mm[1]);
            prop_assert_eq!(slab.start, next);
            prop_assert!(!slab.is_empty());
            next = slab.end;
        }
    }
}

/// Of boxes that are closed to most of the frame some are passed over; and tiles told a row too low lose what shows.
#[test]
fn tiles_in_the_wrong_place_are_seen() {
    let (mut passed_over, mut lost) = (0, 0);
    for seed in 0..96 {
        let target = seeded(&scene(), seed).target(&seeded(&subdivision(Boundary::Exact), seed));
        let camera = seeded(&eye(), seed).camera(&target.lattice.world_bounds());
        let tiles = Tiles::of(camera.size, &seeded(&open(), seed));
        let asked = seeded(&asked(), seed);
        let [remains, must] = found(&target, &camera, &asked, &tiles, &tiles.counted(), [0.0, 1.0]);
        assert!(remains || !must, "seed {seed}");
        passed_over += usize::from(!remains);
        let across = tiles.across();
        let too_low = OpenTiles::new(tiles.size, |tile| tile >= across && tiles.is_open(tile - across));
        let [remains, must] = found(&target, &camera, &asked, &tiles, &too_low, [0.0, 1.0]);
        lost += usize::from(must && !remains);
    }
    println!("{passed_over} of 96 boxes are passed over, {lost} lost with tiles in the wrong place");
    assert!(passed_over > 5, "{passed_over}");
    assert!(lost > 2, "{lost}");
}
