//! Voxels of every type on the GPU: the same picture, as nearly as their numbers are the same. These tests fail, not skip,
//! where there is no adapter.

mod support;

use std::sync::Arc;

use hollowcast::render::Settings;
use hollowcast::sample::{Classification, Sampler};
use hollowcast::skip::Skip;
use hollowcast::volume::{Volume, Voxels, phantom};
use support::{nearness, outside, ramp, renderer};

#[test]
fn signed_wide_and_float_voxels_show_the_same_picture_as_bytes() {
    let mut renderer = renderer();
    let bytes = phantom::make("pot", [40; 3]).unwrap();
    let Voxels::U8(v) = &bytes.voxels else {
        panic!("phantoms are bytes")
    };
    let like = |voxels| Volume {
        name: "pot".to_owned(),
        voxels,
        warnings: Vec::new(),
        dims: bytes.dims,
        spacing: bytes.spacing,
        origin: bytes.origin,
        direction: bytes.direction,
        rescale: bytes.rescale,
    };
    let volumes = [
        (like(Voxels::U8(v.to_vec().into())), ramp(40.0, 255.0, 0.3)),
        (
            like(Voxels::I8(
                v.iter()
                    .map(|&b| (i16::from(b) - 128) as i8)
                    .collect::<Vec<_>>()
                    .into(),
            )),
            ramp(-88.0, 127.0, 0.3),
        ),
        (
            like(Voxels::U16(
                v.iter()
                    .map(|&b| u16::from(b) * 257)
                    .collect::<Vec<_>>()
                    .into(),
            )),
            ramp(40.0 * 257.0, 65535.0, 0.3),
        ),
        (
            like(Voxels::I16(
                v.iter()
                    .map(|&b| (i32::from(b) * 257 - 32768) as i16)
                    .collect::<Vec<_>>()
                    .into(),
            )),
            ramp(40.0 * 257.0 - 32768.0, 32767.0, 0.3),
        ),
        (
            like(Voxels::F32(
                v.iter()
                    .map(|&b| f32::from(b) / 255.0)
                    .collect::<Vec<_>>()
                    .into(),
            )),
            ramp(40.0 / 255.0, 1.0, 0.3),
        ),
    ];
    let mut pictures = Vec::new();
    for (volume, transfer) in volumes {
        let volume = Arc::new(volume);
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer);
        for entries in [256, 65536] {
            let mut settings = outside(&volume, Skip::Box, Sampler::Exact);
            settings.table_entries = entries;
            let picture = renderer.render(&settings).unwrap().picture;
            settings.skip = Skip::HalfSplit;
            assert_eq!(
                renderer
                    .render(&settings)
                    .unwrap()
                    .picture
                    .difference(&picture)
                    .pixels,
                0
            );
            // What its samples come from holds the voxels in their own type too, and is more than others keep.
            settings.skip = Skip::BeamCells;
            settings.block = 4;
            let with_bricks = renderer.prepare(&settings).unwrap().structure_bytes;
            let drawn = renderer.render(&settings).unwrap().picture;
            assert_eq!(
                drawn.difference(&picture).pixels,
                0,
                "{}",
                volume.voxels.voxel_type().name()
            );
            settings.sampler = Some(Sampler::Nearest);
            let without = renderer.prepare(&settings).unwrap().structure_bytes;
            assert!(with_bricks > without, "{with_bricks} and {without} bytes");
            pictures.push(picture);
        }
    }
    assert!(pictures[0].rgba.iter().any(|p| p[3] > 0.5));
    for picture in &pictures[1..] {
        let (db, _) = nearness(picture, &pictures[0]);
        assert!(db > 55.0, "{db} dB");
    }
}

#[test]
fn bricks_follow_table_sampler_classification_block_and_volume() {
    let mut renderer = renderer();
    let tables = [
        ramp(40.0, 255.0, 0.3),
        ramp(150.0, 255.0, 0.3),
        ramp(0.0, 255.0, 0.3),
    ];
    let mut shown = 0;
    for name in ["pot", "shells", "pot"] {
        let volume = Arc::new(phantom::make(name, [40, 37, 41]).unwrap());
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        for table in [0, 1, 0, 2, 0] {
            renderer.set_transfer(tables[table].clone());
            for (sampler, classification, block) in [
                (Sampler::Exact, Classification::Post, 4),
                (Sampler::Hardware, Classification::Post, 4),
                (Sampler::Exact, Classification::Pre, 4),
                (Sampler::Exact, Classification::Post, 8),
            ] {
                let settings = Settings {
                    classification,
                    block,
                    size: [48; 2],
                    ..outside(&volume, Skip::Box, sampler)
                };
                let boxed = renderer.render(&settings).unwrap().picture;
                shown += boxed.rgba.iter().filter(|p| p[3] > 0.0).count();
                for skip in [Skip::BeamCells, Skip::Oracle] {
                    let drawn = renderer.render(&Settings { skip, ..settings }).unwrap();
                    let off = drawn.picture.difference(&boxed).pixels;
                    assert_eq!(off, 0, "{name}, table {table}, {settings:?}");
                }
            }
        }
    }
    assert!(shown > 0);
}

#[test]
fn a_background_at_the_threshold_stays_invisible_far_up_in_16_bits() {
    // Unorm conversion rounds by more, the larger the stored number; the snap must reach as far.
    let mut renderer = renderer();
    let bytes = phantom::make("shells", [40; 3]).unwrap();
    let Voxels::U8(v) = &bytes.voxels else {
        panic!("phantoms are bytes")
    };
    let voxels: Vec<u16> = v.iter().map(|&b| 60_000 + u16::from(b) / 2).collect();
    let volume = Arc::new(Volume {
        voxels: Voxels::U16(voxels.into()),
        ..bytes
    });
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    for threshold in [60_000.0, 60_010.0, 60_033.0] {
        renderer.set_transfer(ramp(threshold, 60_127.0, 0.3));
        for sampler in Sampler::ALL {
            for entries in [256, 4096] {
                let mut settings = outside(&volume, Skip::Box, *sampler);
                settings.table_entries = entries;
                settings.block = 4;
                let counted = renderer.count(&settings).unwrap();
                settings.skip = Skip::Hull;
                let skipped = renderer.count(&settings).unwrap();
                assert_eq!(counted.picture.difference(&skipped.picture).pixels, 0);
                assert_eq!(counted.counters.contributing, skipped.counters.contributing);
            }
        }
    }
}
