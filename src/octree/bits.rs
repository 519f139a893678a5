//! Rows of bits in 64-bit words, bit i of a row being bit i % 64 of word i / 64.

use std::ops::Range;

/// The bits of word `word` that lie in `range` of the row.
#[inline]
pub(super) fn word_mask(range: &Range<usize>, word: usize) -> u64 {
    let first = range.start.saturating_sub(word * 64);
    let end = range.end.saturating_sub(word * 64).min(64);
    if first >= end {
        0
    } else {
        (u64::MAX >> (64 - (end - first))) << first
    }
}

/// Sets the bits of `range`.
pub(super) fn fill(row: &mut [u64], range: &Range<usize>) {
    if range.is_empty() {
        return;
    }
    for (word, bits) in row
        .iter_mut()
        .enumerate()
        .take(range.end.div_ceil(64))
        .skip(range.start / 64)
    {
        *bits |= word_mask(range, word);
    }
}

/// The first run of set bits at or after bit `from`.
pub(super) fn next_run(row: &[u64], from: usize) -> Option<Range<usize>> {
    let mut word = from / 64;
    let mut bits = *row.get(word)? & (u64::MAX << (from % 64));
    while bits == 0 {
        word += 1;
        bits = *row.get(word)?;
    }
    let first = bits.trailing_zeros() as usize;
    let start = word * 64 + first;
    let mut end = start + (bits >> first).trailing_ones() as usize;
    while end.is_multiple_of(64) && end / 64 < row.len() {
        let more = row[end / 64].trailing_ones() as usize;
        end += more;
        if more < 64 {
            break;
        }
    }
    Some(start..end)
}

/// Transposes a 64 x 64 matrix of bits: bit c of word r becomes bit r of word c.
///
/// Swaps off-diagonal squares of 32, 16, ... 1 bits, in all squares of one size at once.
pub(super) fn transpose(rows: &mut [u64; 64]) {
    let mut size = 32;
    let mut low_half = u64::MAX >> 32;
    while size > 0 {
        let mut r = 0;
        while r < 64 {
            let swap = ((rows[r] >> size) ^ rows[r + size]) & low_half;
            rows[r] ^= swap << size;
            rows[r + size] ^= swap;
            r = (r + size + 1) & !size;
        }
        size /= 2;
        low_half ^= low_half << size;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn transposing_moves_every_bit_across_the_diagonal(rows in prop::collection::vec(any::<u64>(), 64)) {
            let before: [u64; 64] = rows.try_into().expect("64 words");
            let mut after = before;
            transpose(&mut after);
            for (r, row) in before.iter().enumerate() {
                for (c, column) in after.iter().enumerate() {
                    prop_assert_eq!(row >> c & 1, column >> r & 1);
                }
            }
        }

        #[test]
        fn a_filled_range_is_the_only_run(start in 0usize..200, len in 1usize..200) {
            let range = start..(start + len).min(256);
            let mut row = [0; 4];
            fill(&mut row, &range);
            for bit in 0..256 {
                prop_assert_eq!(row[bit / 64] >> (bit % 64) & 1 == 1, range.contains(&bit));
            }
            prop_assert_eq!(next_run(&row, 0), Some(range.clone()));
            prop_assert_eq!(next_run(&row, range.end), None);
        }
    }
}
