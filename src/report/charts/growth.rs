//! Time as the work grows.

use super::super::figure::{self, Axis, Figure, Series};
use super::super::model::{Case, Model};
use super::super::papers::REAL_TIME_MS;
use super::{by, edges, fastest_blocks, file_name, ms, noise, varied};
use crate::measure::statistics::line_through;

/// Frame time over the size of volumes of one family.
pub(super) fn over_volumes(model: &Model) -> Vec<Figure> {
    let of_families = model.usual().filter(|c| c.scene.family.is_some());
    let groups = by(of_families, |c| {
        let family = c.scene.family.as_deref().unwrap_or_default();
        let record = c.record;
        let size = edges(record.size);
        format!("{family}-{}-{size}-{}", record.step, record.ert)
    });
    let figure = |(key, cases): (String, Vec<Case>)| {
        let growing = growing(&cases, voxels_an_axis, 2)?;
        let first = growing.cases[0];
        let family = first.scene.family.as_deref().unwrap_or_default();
        Some(Figure {
            id: format!("volume-size-{}", file_name(&key)),
            title: format!(
                "Frame time over volume size: {family}, step {}",
                first.record.step
            ),
            note: format!(
                "Beside figure 4 of the paper on standard accelerators, which draws such curves for a VolumePro 1000 and four \
                 graphics cards without giving numbers: it finds the board's growth linear and that of the cards quadratic, \
                 and calls {REAL_TIME_MS} ms real time. {} {}",
                growing.exponents(),
                noise(&growing.cases)
            ),
            x: Axis::chosen("voxels an axis"),
            y: Axis::new("ms a frame"),
            series: growing.series,
            levels: vec![(REAL_TIME_MS, "20 ms: real time".to_owned())],
            ..Figure::default()
        })
    };
    groups.into_iter().filter_map(figure).collect()
}

/// Frame time over the size of pictures.
pub(super) fn over_images(model: &Model) -> Vec<Figure> {
    let groups = by(model.usual(), |c| {
        format!("{}-{}-{}", c.scene.name, c.record.step, c.record.ert)
    });
    let figure = |(key, cases): (String, Vec<Case>)| {
        // Methods that were measured in one size alone tell nothing of growth.
        let growing = growing(&cases, pixels_an_axis, 3)?;
        let first = growing.cases[0];
        Some(Figure {
            id: format!("image-size-{}", file_name(&key)),
            title: format!(
                "Frame time over image size: {}, step {}",
                first.scene.title, first.record.step
            ),
            note: format!("{} {}", growing.exponents(), noise(&growing.cases)),
            x: Axis::chosen("pixels an axis"),
            y: Axis::new("ms a frame"),
            series: growing.series,
            ..Figure::default()
        })
    };
    groups.into_iter().filter_map(figure).collect()
}

/// Cases of several sizes.
struct Growing<'a> {
    cases: Vec<Case<'a>>,
    series: Vec<Series>,
}

/// The cases whose method was measured in so many sizes at least; `None` where there are none.
fn growing<'a>(cases: &[Case<'a>], size: fn(&Case) -> f64, least: usize) -> Option<Growing<'a>> {
    let mut cases = fastest_blocks(varied(cases, size, least).into_iter());
    cases.sort_by(|a, b| size(a).total_cmp(&size(b)));
    let mut series = Vec::new();
    for case in &cases {
        let point = case.point(size(case), ms(case));
        figure::add(&mut series, &case.record.method, &case.kind(), point);
    }
    (!cases.is_empty()).then_some(Growing { cases, series })
}

impl Growing<'_> {
    /// The slopes of the series between logarithms, in words.
    fn exponents(&self) -> String {
        let exponent = |s: &Series| {
            let logs: Vec<[f64; 2]> = s.points.iter().map(|p| [p.x.ln(), p.y.ln()]).collect();
            format!("{} ({}) {:.2}", s.method, s.kind, line_through(&logs)[1])
        };
        let exponents: Vec<String> = self.series.iter().map(exponent).collect();
        format!(
            "Exponents of time over what is across, fitted by least squares between logarithms: {}.",
            exponents.join("; ")
        )
    }
}

fn voxels_an_axis(case: &Case) -> f64 {
    let voxels: f64 = case.scene.dims.iter().map(|&n| n as f64).product();
    voxels.cbrt()
}

fn pixels_an_axis(case: &Case) -> f64 {
    case.record
        .size
        .map(f64::from)
        .iter()
        .product::<f64>()
        .sqrt()
}
