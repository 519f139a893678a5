//! Tables for the eye: columns as wide as their widest cell.

use hollowcast::measure::compare::Row;

/// Right-aligned columns under their heads; the first `left` columns are left-aligned.
pub(super) fn columns(head: &[&str], rows: &[Vec<String>], left: usize) -> String {
    let widths: Vec<usize> = head
        .iter()
        .enumerate()
        .map(|(c, h)| {
            let cells = rows.iter().map(|row| row[c].chars().count());
            cells.chain([h.chars().count()]).max().unwrap_or(0)
        })
        .collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let padded: Vec<String> = cells
            .zip(&widths)
            .enumerate()
            .map(|(c, (cell, &width))| {
                if c < left {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            })
            .collect();
        format!("{}\n", padded.join("  ").trim_end())
    };
    let mut text = line(&mut head.iter().copied());
    for row in rows {
        text.push_str(&line(&mut row.iter().map(String::as_str)));
    }
    text
}

/// The rows of a comparison. What all of them share stands above the table, not in it.
pub(super) fn comparison(rows: &[Row]) -> String {
    let head = [
        "backend",
        "method",
        "step",
        "block",
        "frame ms",
        "quartiles",
        "x box",
        "raster ms",
        "cast ms",
        "build ms",
        "cull ms",
        "samples/px",
        "used/px",
        "skips/px",
        "KiB",
        "pixels off",
        "max off",
        "PSNR dB",
    ];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|r| {
            let psnr = match r.psnr_vs_reference_db {
                Some(db) if db.is_finite() => format!("{db:.1}"),
                Some(_) => "equal".to_owned(),
                None => "-".to_owned(),
            };
            vec![
                r.backend.to_owned(),
                r.method.to_owned(),
                r.step.clone(),
                r.block.to_string(),
                format!("{:.1}", r.frame_ms),
                format!("{:.1}-{:.1}", r.frame_q1_ms, r.frame_q3_ms),
                format!("{:.2}", r.speedup_vs_box),
                format!("{:.1}", r.raster_ms),
                format!("{:.1}", r.cast_ms),
                format!("{:.1}", r.preprocess_ms),
                format!("{:.1}", r.cull_ms),
                format!("{:.1}", r.samples_per_pixel),
                format!("{:.1}", r.contributing_samples_per_pixel),
                format!("{:.1}", r.skip_steps_per_pixel),
                r.structure_bytes.div_ceil(1024).to_string(),
                r.differing_pixels_vs_box.to_string(),
                format!("{}", r.max_abs_diff_vs_box),
                psnr,
            ]
        })
        .collect();
    columns(&head, &cells, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = [["a", "1"], ["long", "1000"]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(
            columns(&["name", "ms"], &rows, 1),
            "name    ms\na        1\nlong  1000\n"
        );
    }
}
