//! The rows of a sweep over block sizes: in order, and as lines of a chart.

use hollowcast::measure::tune::Row;
use hollowcast::output::chart::Line;
use hollowcast::skip::Skip;

/// Backend by backend, method by method, small blocks first.
pub(super) fn in_order_of_the_sweep(rows: &mut [Row]) {
    let place = |row: &Row| {
        let methods = hollowcast::skip::METHODS;
        methods.iter().position(|m| m.name == row.method)
    };
    rows.sort_by_key(|row| (row.backend, place(row), row.block));
}

/// A line for each method; box, which reads no block, lies level.
pub(super) fn lines(rows: &[Row], with_backend: bool, number: fn(&Row) -> f64) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let blocks = || {
        rows.iter()
            .filter(|r| r.choice.skip != Skip::Box)
            .map(|r| r.block)
    };
    for row in rows {
        let name = if with_backend {
            format!("{} {}", row.backend, row.method)
        } else {
            row.method.to_owned()
        };
        let points = if row.choice.skip == Skip::Box {
            let ends = [blocks().min(), blocks().max()];
            let level = |block: Option<usize>| block.map(|b| [b as f64, number(row)]);
            ends.into_iter().filter_map(level).collect()
        } else {
            vec![[row.block as f64, number(row)]]
        };
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.extend(points),
            None => lines.push(Line { name, points }),
        }
    }
    lines
}
