//! Every case.

use super::super::charts::noise;
use super::super::model::Model;
use super::super::number::{bytes, percent, short};
use super::{NONE, Row, Table, commands, head, or_none};
use crate::measure::suite::ErrorRecord;

/// Every case with all that was measured of it.
pub(super) fn table(model: &Model) -> Table {
    let rows = model.cases.iter().map(|case| {
        let r = case.record;
        let error =
            |f: &dyn Fn(&ErrorRecord) -> String| r.error.as_ref().map_or(NONE.to_owned(), f);
        Row {
            cells: vec![
                case.scene.title.clone(),
                r.chosen.as_ref().map_or_else(
                    || r.method.clone(),
                    |chosen| format!("{}: {chosen}", r.method),
                ),
                case.kind(),
                r.mode.clone(),
                r.step.clone(),
                // Box has none, and what auto chose says its own.
                if r.method == "box" || r.method == "auto" {
                    NONE.to_owned()
                } else {
                    r.block.to_string()
                },
                r.ert.clone(),
                format!("{}x{}", r.size[0], r.size[1]),
                format!(
                    "{} ({} to {})",
                    short(r.frame_ms.median),
                    short(r.frame_ms.q1),
                    short(r.frame_ms.q3)
                ),
                short(r.box_ms / r.frame_ms.median),
                r.noise.map_or(NONE.to_owned(), percent),
                short(r.samples),
                short(r.contributing),
                short(r.skip_steps),
                bytes(r.structure_bytes),
                r.differing_pixels_vs_box.to_string(),
                short(r.max_abs_vs_box),
                error(&|e| short(e.rms)),
                error(&|e| short(e.max_abs)),
                error(&|e| short(-20.0 * e.rms.log10())),
                error(&|e| percent(e.off_share)),
                error(&|e| or_none(e.ssim)),
                error(&|e| or_none(e.flip)),
            ],
            is_published: false,
            commands: commands([case]),
        }
    });
    Table {
        id: "everything".to_owned(),
        title: "Every case".to_owned(),
        note: format!(
            "Errors are of linear colour multiplied by opacity, full scale 1, against the converged picture of the first view. {}",
            noise(&model.cases)
        ),
        head: head(&[
            "scene",
            "method",
            "where",
            "mode",
            "step",
            "block",
            "ERT",
            "size",
            "ms (quartiles)",
            "times box",
            "noise %",
            "samples/px",
            "contributing/px",
            "skip steps/px",
            "memory",
            "pixels off box",
            "most off box",
            "RMS",
            "max",
            "PSNR dB",
            "% off by 1/255",
            "SSIM",
            "FLIP",
        ]),
        rows: rows.collect(),
    }
}
