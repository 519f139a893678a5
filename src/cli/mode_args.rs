//! Arguments that choose a mode and its parameters.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use hollowcast::mode::{Light, Lighting, MODES, Mode, ModeRow, Window};
use hollowcast::sample::Gradients;
use hollowcast::volume::Statistics;
use hollowcast::{Error, Result};

use super::values::{self, Background};

/// The mode and what it can be told. A parameter that was not given suits the data.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Mode")]
pub(super) struct ModeArgs {
    /// What is done with the samples
    #[arg(long, default_value = MODES[0].name, value_parser = named())]
    mode: &'static ModeRow,

    /// Data values of brightness 0 and 1 in grey, mip, minip, mean [default: from the end of the background, in minip from the lowest, to the highest]
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = window)]
    window: Option<Window>,

    /// Data value from which on matter is solid in normals, phong, two-surfaces [default: the end of the background]
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    iso: Option<f64>,

    /// The same of the inner of two surfaces [default: halfway from --iso to the highest value]
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    iso2: Option<f64>,

    /// Where the light comes from: headlight (the eye) or a direction in the volume's axes [default: headlight]
    #[arg(long, value_name = "X,Y,Z|headlight", allow_hyphen_values = true, value_parser = light)]
    light: Option<Light>,

    /// Ambient reflection [default: 0.15]
    #[arg(long, value_name = "K", allow_hyphen_values = true)]
    ka: Option<f64>,

    /// Diffuse reflection [default: 0.75]
    #[arg(long, value_name = "K", allow_hyphen_values = true)]
    kd: Option<f64>,

    /// Specular reflection [default: 0.25]
    #[arg(long, value_name = "K", allow_hyphen_values = true)]
    ks: Option<f64>,

    /// Exponent of specular reflection [default: 32]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    shininess: Option<f64>,

    /// Colour of the (inner) surface, sRGB
    #[arg(long, value_name = "#RRGGBB", value_parser = color)]
    surface_color: Option<[f64; 3]>,

    /// Colour of the outer of two surfaces, sRGB
    #[arg(long, value_name = "#RRGGBB", value_parser = color)]
    outer_color: Option<[f64; 3]>,

    /// Opacity of the outer of two surfaces [default: 0.3]
    #[arg(long, value_name = "OPACITY", allow_hyphen_values = true)]
    outer_opacity: Option<f64>,

    /// Where shaded, normals, phong, two-surfaces take gradients from: central differences on the fly, or a volume of them at
    /// full, half or quarter resolution [default: fly]
    #[arg(long, value_parser = values::named(Gradients::ALL, Gradients::name))]
    gradients: Option<Gradients>,

    /// Share of light that colours lose at the farthest point of the box, 0 to 1; not in mip, minip, mean, normals
    #[arg(
        long,
        value_name = "STRENGTH",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub(super) depth_cue: f64,
}

impl ModeArgs {
    /// Where gradients come from.
    pub(super) fn gradients(&self) -> Gradients {
        self.gradients.unwrap_or(Gradients::Fly)
    }

    /// The mode for data of these statistics. What the user should know of it goes to stderr.
    pub(super) fn mode(&self, statistics: &Statistics) -> Result<Mode> {
        let mut left = Left(self.given());
        let mut mode = (self.mode.suited_to)(statistics);
        match &mut mode {
            Mode::EmissionAbsorption => {}
            Mode::Shaded(lighting) => self.light_up(lighting, &mut left),
            Mode::Grey(window) | Mode::Mip(window) | Mode::Minip(window) | Mode::Mean(window) => {
                left.put("--window", self.window, window);
            }
            Mode::Normals { iso } => left.put("--iso", self.iso, iso),
            Mode::Phong {
                iso,
                color,
                lighting,
            } => {
                left.put("--iso", self.iso, iso);
                left.put("--surface-color", self.surface_color, color);
                self.light_up(lighting, &mut left);
            }
            Mode::TwoSurfaces {
                outer,
                iso,
                color,
                lighting,
            } => {
                let halfway = |outer: f64| {
                    let [_, high] = statistics.value_range();
                    (outer + high.max(outer + 1.0)) * 0.5
                };
                left.put("--iso", self.iso, &mut outer.iso);
                left.put("--outer-color", self.outer_color, &mut outer.color);
                left.put("--outer-opacity", self.outer_opacity, &mut outer.opacity);
                *iso = halfway(outer.iso);
                left.put("--iso2", self.iso2, iso);
                left.put("--surface-color", self.surface_color, color);
                self.light_up(lighting, &mut left);
            }
        }
        if mode.takes_gradients() {
            left.put("--gradients", None, &mut ());
        }
        if let Some(flag) = left.0.first() {
            let reason = format!("the mode {} does not read it", mode.name());
            return Err(Error::setting(*flag, reason));
        }
        mode.check()?;
        if let Some(warning) = mode.warning(statistics) {
            eprintln!("warning: {warning}");
        }
        Ok(mode)
    }

    /// The modes of these names, or all, each with what suits data of these statistics.
    pub(super) fn modes(&self, names: &[String], statistics: &Statistics) -> Result<Vec<Mode>> {
        if let Some(flag) = self.given().first() {
            let reason = "is for one --mode: with --modes, parameters suit the data";
            return Err(Error::setting(*flag, reason));
        }
        let is_asked = |row: &&ModeRow| names.iter().any(|n| n == row.name || n == ALL);
        let rows = MODES.iter().filter(is_asked);
        Ok(rows.map(|row| (row.suited_to)(statistics)).collect())
    }

    fn light_up(&self, lighting: &mut Lighting, left: &mut Left) {
        left.put("--light", self.light, &mut lighting.light);
        left.put("--ka", self.ka, &mut lighting.ambient);
        left.put("--kd", self.kd, &mut lighting.diffuse);
        left.put("--ks", self.ks, &mut lighting.specular);
        left.put("--shininess", self.shininess, &mut lighting.shininess);
    }

    /// The flags that were given.
    fn given(&self) -> Vec<&'static str> {
        let flags = [
            ("--window", self.window.is_some()),
            ("--iso", self.iso.is_some()),
            ("--iso2", self.iso2.is_some()),
            ("--light", self.light.is_some()),
            ("--ka", self.ka.is_some()),
            ("--kd", self.kd.is_some()),
            ("--ks", self.ks.is_some()),
            ("--shininess", self.shininess.is_some()),
            ("--surface-color", self.surface_color.is_some()),
            ("--outer-color", self.outer_color.is_some()),
            ("--outer-opacity", self.outer_opacity.is_some()),
            ("--gradients", self.gradients.is_some()),
        ];
        let given = flags.iter().filter(|(_, is_given)| *is_given);
        given.map(|(flag, _)| *flag).collect()
    }
}

/// Flags that were given and that nothing has read yet.
struct Left(Vec<&'static str>);

impl Left {
    /// Puts a flag's value, if there is one, where it belongs.
    fn put<T>(&mut self, flag: &str, value: Option<T>, place: &mut T) {
        self.0.retain(|left| *left != flag);
        if let Some(value) = value {
            *place = value;
        }
    }
}

/// Every mode there is.
const ALL: &str = "all";

/// The names of modes, and `all`.
pub(super) fn names() -> PossibleValuesParser {
    PossibleValuesParser::new([ALL].into_iter().chain(MODES.iter().map(|row| row.name)))
}

/// A mode's row by its name, explained in the help text.
fn named() -> impl TypedValueParser<Value = &'static ModeRow> {
    let values = MODES
        .iter()
        .map(|row| PossibleValue::new(row.name).help(row.summary));
    PossibleValuesParser::new(values).map(|given| {
        MODES
            .iter()
            .find(|row| row.name == given)
            .expect("clap has checked the name")
    })
}

fn window(text: &str) -> std::result::Result<Window, String> {
    let number = |s: &str| s.parse().ok();
    let ends = text.split_once(':');
    ends.and_then(|(low, high)| {
        Some(Window {
            low: number(low)?,
            high: number(high)?,
        })
    })
    .ok_or_else(|| "expected LOW:HIGH, two data values, as 40:200".to_owned())
}

fn light(text: &str) -> std::result::Result<Light, String> {
    if text == "headlight" {
        return Ok(Light::Headlight);
    }
    values::vector(text)
        .map(Light::From)
        .map_err(|_| "expected headlight or three numbers, as 1,-1,2.5".to_owned())
}

fn color(text: &str) -> std::result::Result<[f64; 3], String> {
    let expected = "expected an sRGB colour as #rrggbb";
    let Background(color) = text.parse().map_err(|_| expected)?;
    color.map(|c| c.map(f64::from)).ok_or(expected.to_owned())
}
