//! A background lies behind the pictures of every mode, as far as they are transparent.

use std::path::Path;
use std::process::Command;

use hollowcast::mode::MODES;

/// Straight sRGB bytes of a PNG's pixels.
fn pixels(path: &Path) -> Vec<[u8; 4]> {
    let picture = image::open(path).unwrap().to_rgba8();
    picture.pixels().map(|p| p.0).collect()
}

#[test]
fn every_mode_lies_over_the_background() {
    let folder = tempfile::tempdir().unwrap();
    for row in MODES {
        let draw = |background: &str| {
            let path = folder.path().join("picture.png");
            let output = Command::new(env!("CARGO_BIN_EXE_hollowcast"))
                .args(["render", "phantom:sphere:24", "--backend", "reference"])
                .args(["--size", "32x32", "--method", "box", "--step", "1"])
                .args(["--mode", row.name, "--background", background, "-o"])
                .arg(&path)
                .output()
                .unwrap();
            assert!(output.status.success(), "{}: {output:?}", row.name);
            pixels(&path)
        };
        let [none, blue] = [draw("none"), draw("#a0c0e0")];
        assert!(blue.iter().all(|p| p[3] == 255), "{}", row.name);
        // The corner's ray misses the box.
        assert_eq!(
            (none[0][3], blue[0]),
            (0, [0xa0, 0xc0, 0xe0, 255]),
            "{}",
            row.name
        );
        for (none, blue) in none.iter().zip(&blue) {
            // What is opaque hides it, what is not lets it through.
            assert_eq!(
                none[3] == 255,
                none[3] == 255 && none == blue,
                "{}",
                row.name
            );
            // Half of the least opacity that a byte tells moves a byte of colour by one at most.
            let is_near = |c: usize| blue[c].abs_diff([0xa0, 0xc0, 0xe0][c]) <= 1;
            assert!(none[3] > 0 || (0..3).all(is_near), "{}", row.name);
        }
        assert!(none.iter().any(|p| p[3] > 30), "{} shows nothing", row.name);
    }
}
