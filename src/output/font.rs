//! A font of 3 x 5 dots, enough for captions and the numbers of a legend.

use crate::scene::Picture;

/// Pixels per dot.
const DOT: u32 = 2;
/// Height of a line in pixels, with a dot of margin above and below.
pub(super) const HEIGHT: u32 = 7 * DOT;

/// The dots of a character, row by row, three bits each, top row highest. Unknown characters are blank.
fn glyph(c: char) -> u16 {
    match c {
        '0' => 0b111_101_101_101_111,
        '1' => 0b010_110_010_010_111,
        '2' => 0b111_001_111_100_111,
        '3' => 0b111_001_111_001_111,
        '4' => 0b101_101_111_001_001,
        '5' => 0b111_100_111_001_111,
        '6' => 0b111_100_111_101_111,
        '7' => 0b111_001_010_010_010,
        '8' => 0b111_101_111_101_111,
        '9' => 0b111_101_111_001_111,
        'a' => 0b010_101_111_101_101,
        'b' => 0b110_101_110_101_110,
        'c' => 0b011_100_100_100_011,
        'd' => 0b110_101_101_101_110,
        'e' => 0b111_100_110_100_111,
        'f' => 0b111_100_110_100_100,
        'g' => 0b011_100_101_101_011,
        'h' => 0b101_101_111_101_101,
        'i' => 0b111_010_010_010_111,
        'j' => 0b001_001_001_101_010,
        'k' => 0b101_101_110_101_101,
        'l' => 0b100_100_100_100_111,
        'm' => 0b101_111_111_101_101,
        'n' => 0b110_101_101_101_101,
        'o' => 0b010_101_101_101_010,
        'p' => 0b110_101_110_100_100,
        'q' => 0b010_101_101_111_011,
        'r' => 0b110_101_110_101_101,
        's' => 0b011_100_010_001_110,
        't' => 0b111_010_010_010_010,
        'u' => 0b101_101_101_101_111,
        'v' => 0b101_101_101_101_010,
        'w' => 0b101_101_111_111_101,
        'x' => 0b101_101_010_101_101,
        'y' => 0b101_101_010_010_010,
        'z' => 0b111_001_010_100_111,
        '-' => 0b000_000_111_000_000,
        '.' => 0b000_000_000_000_010,
        ':' => 0b000_010_000_010_000,
        '/' => 0b001_001_010_100_100,
        _ => 0,
    }
}

/// Width of a text in pixels.
pub(super) fn width(text: &str) -> u32 {
    text.chars().count() as u32 * 4 * DOT
}

/// Draws white letters (capitals look like small ones) from column `left` of the top line; what does not fit is cut off.
pub(super) fn draw(picture: &mut Picture, text: &str, left: u32) {
    for (i, c) in text.chars().enumerate() {
        let dots = glyph(c.to_ascii_lowercase());
        for bit in (0..15u32).filter(|bit| dots >> (14 - bit) & 1 == 1) {
            let x0 = left + (i as u32 * 4 + bit % 3) * DOT;
            let y0 = (bit / 3 + 1) * DOT;
            for (x, y) in (0..DOT * DOT).map(|d| (x0 + d % DOT, y0 + d / DOT)) {
                if x < picture.size[0] && y < picture.size[1] {
                    picture.rgba[(y * picture.size[0] + x) as usize] = [1.0; 4];
                }
            }
        }
    }
}
