//! Pictures in closed form, whose measures other implementations were asked for.

use super::plane::Plane;

/// Red, green and blue of two pictures of 32 x 24 pixels, linear, 0 to 1.
pub(super) fn pictures() -> [[Plane; 3]; 2] {
    const SIZE: [usize; 2] = [32, 24];
    let plane = |f: &dyn Fn(usize, usize) -> f64| {
        Plane::new(
            SIZE,
            (0..SIZE[0] * SIZE[1]).map(|i| f(i % SIZE[0], i / SIZE[0])),
        )
    };
    let red = |x: usize, y: usize| ((x * 7 + y * 3) % 32) as f64 / 31.0;
    let green = |x: usize, y: usize| ((x * 5 + y * 11) % 24) as f64 / 23.0;
    let blue = |x: usize, _: usize| x as f64 / 31.0 * 0.5 + 0.25;
    let patched = |x: usize, y: usize| {
        if (10..20).contains(&x) && (8..14).contains(&y) {
            0.5
        } else {
            green(x, y)
        }
    };
    [
        [plane(&red), plane(&green), plane(&blue)],
        [
            plane(&|x, y| red(x, y) * 0.9),
            plane(&patched),
            plane(&|x, y| blue(x, y).powf(1.1)),
        ],
    ]
}
