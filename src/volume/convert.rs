//! Types that a volume does not keep, brought to one that it does, with the loss stated.

use half::f16;
use rayon::prelude::*;

use super::Voxels;
use super::store::Store;

/// Voxels and what was lost; `None` where no voxel is finite.
pub(super) type Converted = Option<(Voxels, Vec<String>)>;

/// f32 data with NaN and infinities replaced by the smallest finite number; mapped data stay mapped where all is well.
pub(super) fn finite(store: Store<f32>) -> Converted {
    let lost = store.par_iter().filter(|v| !v.is_finite()).count();
    if lost == 0 {
        return Some((Voxels::F32(store), Vec::new()));
    }
    let lowest = store
        .par_iter()
        .copied()
        .filter(|v| v.is_finite())
        .reduce_with(f32::min)?;
    let voxels: Vec<f32> = store
        .par_iter()
        .map(|&v| if v.is_finite() { v } else { lowest })
        .collect();
    let warning =
        format!("{lost} voxels were not finite: set to the smallest finite value, {lowest}");
    Some((Voxels::F32(voxels.into()), vec![warning]))
}

/// 16-bit floats, given by their bits: all of them are f32 numbers too.
pub(super) fn from_f16(bits: &[u16]) -> Converted {
    let voxels: Vec<f32> = bits
        .par_iter()
        .map(|&b| f16::from_bits(b).to_f32())
        .collect();
    finite(voxels.into())
}

/// The smallest type of integers that holds `low..=high`, filled with `get(0..n)`.
fn narrow(n: usize, [low, high]: [i128; 2], get: impl Fn(usize) -> i64 + Sync) -> Option<Voxels> {
    fn collect<T: Send>(n: usize, get: impl Fn(usize) -> T + Sync + Send) -> Store<T> {
        Store::Owned((0..n).into_par_iter().map(get).collect())
    }
    let fits = |min: i128, max: i128| min <= low && high <= max;
    Some(if fits(0, 255) {
        Voxels::U8(collect(n, |i| get(i) as u8))
    } else if fits(-128, 127) {
        Voxels::I8(collect(n, |i| get(i) as i8))
    } else if fits(0, 65535) {
        Voxels::U16(collect(n, |i| get(i) as u16))
    } else if fits(-32768, 32767) {
        Voxels::I16(collect(n, |i| get(i) as i16))
    } else {
        return None;
    })
}

fn lossless(from: &str, to: &Voxels) -> Vec<String> {
    vec![format!(
        "{from} voxels are kept as {}, without loss",
        to.voxel_type().name()
    )]
}

/// Integers of 32 and 64 bits: as smaller integers where all fit, else as f32.
pub(super) fn from_integers<T>(numbers: &[T], name: &str) -> Converted
where
    T: Copy + Ord + Into<i128> + Send + Sync,
{
    let low: i128 = (*numbers.par_iter().min()?).into();
    let high: i128 = (*numbers.par_iter().max()?).into();
    let small = narrow(numbers.len(), [low, high], |i| numbers[i].into() as i64);
    if let Some(voxels) = small {
        let warnings = lossless(name, &voxels);
        return Some((voxels, warnings));
    }
    let rounding = |v: T| {
        let exact: i128 = v.into();
        (exact as f32 as i128).abs_diff(exact)
    };
    let rounded = numbers.par_iter().filter(|v| rounding(**v) > 0).count();
    let worst = numbers.par_iter().map(|v| rounding(*v)).max()?;
    let voxels: Vec<f32> = numbers
        .par_iter()
        .map(|&v| Into::<i128>::into(v) as f32)
        .collect();
    let warning =
        format!("{name} voxels are kept as float32: {rounded} were rounded, by at most {worst}");
    Some((Voxels::F32(voxels.into()), vec![warning]))
}

/// 64-bit floats: as integers where all are small ones, else as f32.
pub(super) fn from_f64(numbers: &[f64]) -> Converted {
    let whole = |v: &f64| v.fract() == 0.0 && v.abs() <= 65535.0;
    if numbers.par_iter().all(whole) {
        let low = numbers.par_iter().copied().reduce_with(f64::min)?;
        let high = numbers.par_iter().copied().reduce_with(f64::max)?;
        let small = narrow(numbers.len(), [low as i128, high as i128], |i| {
            numbers[i] as i64
        });
        if let Some(voxels) = small {
            let warnings = lossless("float64", &voxels);
            return Some((voxels, warnings));
        }
    }
    let limit = f64::from(f32::MAX);
    let narrowed = |v: f64| {
        if v.is_finite() {
            v.clamp(-limit, limit) as f32
        } else {
            v as f32
        }
    };
    let voxels: Vec<f32> = numbers.par_iter().map(|&v| narrowed(v)).collect();
    let worst = numbers
        .par_iter()
        .zip(&voxels)
        .filter(|(v, _)| v.is_finite())
        .map(|(v, &kept)| (v - f64::from(kept)).abs())
        .reduce(|| 0.0, f64::max);
    let (voxels, mut warnings) = finite(voxels.into())?;
    if worst > 0.0 {
        warnings.push(format!(
            "float64 voxels are kept as float32: rounded by at most {worst:.3e}"
        ));
    }
    Some((voxels, warnings))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn as_f64(voxels: &Voxels) -> Vec<f64> {
        crate::with_voxels!(voxels, v => v.iter().map(|&s| f64::from(s)).collect())
    }

    #[test]
    fn what_is_kept_as_integers_is_kept_exactly_in_the_smallest_type() {
        for (numbers, name) in [
            (vec![0, 255], "uint8"),
            (vec![-1, 127], "int8"),
            (vec![0, 256], "uint16"),
            (vec![-129, 300], "int16"),
            (vec![-1, 40000], "float32"),
        ] {
            let exact: Vec<f64> = numbers.iter().map(|&n| f64::from(n)).collect();
            let (voxels, warnings) = from_integers::<i32>(&numbers, "int32").unwrap();
            assert_eq!(voxels.voxel_type().name(), name);
            assert_eq!(as_f64(&voxels), exact);
            assert_eq!(warnings.len(), 1);
            let (voxels, _) = from_f64(&exact).unwrap();
            assert_eq!(voxels.voxel_type().name(), name);
            assert_eq!(as_f64(&voxels), exact);
        }
    }

    #[test]
    fn a_loss_is_stated_with_its_size() {
        let (voxels, warnings) = from_integers(&[0_u64, (1 << 24) + 1], "uint64").unwrap();
        assert_eq!(as_f64(&voxels), [0.0, f64::from(1 << 24)]);
        assert!(
            warnings[0].contains("1 were rounded, by at most 1"),
            "{warnings:?}"
        );
        let (voxels, warnings) = from_f64(&[0.1, 1e300, f64::NAN]).unwrap();
        assert_eq!(as_f64(&voxels)[2], f64::from(0.1_f32));
        assert_eq!(as_f64(&voxels)[1], f64::from(f32::MAX));
        assert_eq!(warnings.len(), 2);
    }

    #[test]
    fn what_is_not_finite_becomes_the_smallest_finite_number_and_is_counted() {
        let (voxels, warnings) =
            finite(vec![f32::NAN, 3.0, f32::INFINITY, -2.0, f32::NEG_INFINITY].into()).unwrap();
        assert_eq!(as_f64(&voxels), [-2.0, 3.0, -2.0, -2.0, -2.0]);
        assert!(warnings[0].starts_with("3 voxels"));
        assert!(finite(vec![f32::NAN].into()).is_none());
    }
}
