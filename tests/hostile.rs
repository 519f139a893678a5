//! Damaged, lying and hostile files neither panic nor take memory that their content does not back.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use hollowcast::volume::{RawLayout, Scalar, load, open, read_stored};
use proptest::prelude::*;

use counting::{BUFFERS, peak_of};

#[path = "support/counting.rs"]
mod counting;

/// One test at a time: the counters are the process's.
static ALONE: Mutex<()> = Mutex::new(());

/// Opens a file both ways; an error must be one line that names a file in its folder.
fn try_reading(path: &Path) {
    for error in [open(path, None).err(), read_stored(path, None).err()]
        .into_iter()
        .flatten()
    {
        let line = error.to_string();
        assert_eq!(line.lines().count(), 1, "{line}");
        assert!(
            line.contains(path.parent().unwrap().to_str().unwrap()),
            "{line}"
        );
    }
}

/// A well-formed file of each format and packing: name, header, voxels. 6x5x4 voxels.
fn seeds() -> Vec<(&'static str, Vec<u8>, Vec<u8>)> {
    let voxels: Vec<u8> = (0..240).map(|i| (i * 37 % 251) as u8).collect();
    let gzip = |bytes: &[u8]| {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::new(6));
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    };
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::new(6));
    zlib.write_all(&voxels).unwrap();
    let mut bz = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::new(9));
    bz.write_all(&voxels).unwrap();
    let nrrd = |encoding: &str| {
        format!(
            "NRRD0004\n# made here\ntype: short\ndimension: 3\nsizes: 6 5 4\nspace dimension: 3\n\
             space directions: (1,0,0) (0,1,0) (0,0,2)\nkinds: domain domain domain\nendian: little\nline skip: 0\n\
             byte skip: 0\nencoding: {encoding}\nspace origin: (0,0,0)\nkey:=value\n\n"
        )
        .into_bytes()
    };
    let text: Vec<String> = voxels.chunks(2).map(|v| v[0].to_string()).collect();
    let hex: Vec<String> = voxels.iter().map(|v| format!("{v:02x}")).collect();
    let meta = |packed: &str| {
        format!(
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
             CompressedData = {packed}\nHeaderSize = 0\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\n\
             ElementSpacing = 1 1 2\nDimSize = 6 5 4\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        )
        .into_bytes()
    };
    let mut nifti = vec![0_u8; 352];
    nifti[0..4].copy_from_slice(&348_i32.to_le_bytes());
    for (i, dim) in [3_i16, 6, 5, 4, 1, 1, 1, 1].into_iter().enumerate() {
        nifti[40 + 2 * i..42 + 2 * i].copy_from_slice(&dim.to_le_bytes());
        nifti[76 + 4 * i..80 + 4 * i].copy_from_slice(&1_f32.to_le_bytes());
    }
    nifti[70..72].copy_from_slice(&4_i16.to_le_bytes());
    nifti[72..74].copy_from_slice(&16_i16.to_le_bytes());
    nifti[108..112].copy_from_slice(&352_f32.to_le_bytes());
    nifti[252..254].copy_from_slice(&1_i16.to_le_bytes());
    nifti[344..348].copy_from_slice(b"n+1\0");
    let mut nifti2 = vec![0_u8; 544];
    nifti2[0..4].copy_from_slice(&540_i32.to_le_bytes());
    nifti2[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
    nifti2[12..14].copy_from_slice(&4_i16.to_le_bytes());
    for (i, dim) in [3_i64, 6, 5, 4, 1, 1, 1, 1].into_iter().enumerate() {
        nifti2[16 + 8 * i..24 + 8 * i].copy_from_slice(&dim.to_le_bytes());
        nifti2[104 + 8 * i..112 + 8 * i].copy_from_slice(&1_f64.to_le_bytes());
    }
    nifti2[168..176].copy_from_slice(&544_i64.to_le_bytes());
    nifti2[344..348].copy_from_slice(&1_i32.to_le_bytes());
    let mut den = vec![0_u8; 62];
    den[0] = 1;
    for (i, dim) in [6_u8, 5, 8].into_iter().enumerate() {
        den[50 + 2 * i] = dim;
    }
    den[58] = 240;
    vec![
        ("raw.nrrd", nrrd("raw"), voxels.clone()),
        ("gzip.nrrd", nrrd("gzip"), gzip(&voxels)),
        ("bzip2.nrrd", nrrd("bzip2"), bz.finish().unwrap()),
        ("text.nrrd", nrrd("ascii"), text.join(" ").into_bytes()),
        ("hex.nrrd", nrrd("hex"), hex.concat().into_bytes()),
        ("raw.mha", meta("False"), voxels.clone()),
        ("zlib.mha", meta("True"), zlib.finish().unwrap()),
        ("raw.nii", nifti, voxels.clone()),
        ("two.nii", nifti2, voxels.clone()),
        ("map.den", den, voxels.clone()),
        (
            "side.json",
            br#"{"dims": [6, 5, 4], "type": "int16", "endian": "big", "skip_bytes": 0, "spacing": [1, 1, 2]}"#.to_vec(),
            voxels,
        ),
    ]
}

/// Writes a seed; the sidecar's voxels go into the raw file that it describes. The file to open.
fn write(folder: &Path, name: &str, header: &[u8], voxels: &[u8]) -> PathBuf {
    let path = folder.join(name);
    if name == "side.json" {
        std::fs::write(&path, header).unwrap();
        let raw = folder.join("side.raw");
        std::fs::write(&raw, voxels).unwrap();
        return raw;
    }
    std::fs::write(&path, [header, voxels].concat()).unwrap();
    path
}

/// One change to a header.
#[derive(Debug, Clone)]
enum Mutation {
    /// A byte becomes another.
    Byte(prop::sample::Index, u8),
    /// Bytes are replaced, as numbers that break things are.
    Number(prop::sample::Index, &'static str),
    /// The first decimal number at or after a place becomes another.
    Decimal(prop::sample::Index, &'static str),
    /// A line is left out.
    DropLine(prop::sample::Index),
    /// The file ends early.
    Truncate(prop::sample::Index),
}

const NUMBERS: &[&str] = &[
    "\0\0\0\0",
    "\u{7f}\u{7f}",
    "AAAAAAAA",
    "\u{1}\0\0\0\0\0\0\0",
    "\0\0\u{40}\u{7f}",
];
const DECIMALS: &[&str] = &[
    "0",
    "-1",
    "-5",
    "1",
    "65536",
    "65537",
    "1000000000",
    "4294967296",
    "18446744073709551615",
    "99999999999999999999999",
    "1e308",
    "nan",
    "",
];

fn mutation() -> impl Strategy<Value = Mutation> {
    let at = any::<prop::sample::Index>;
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(i, b)| Mutation::Byte(i, b)),
        (at(), prop::sample::select(NUMBERS)).prop_map(|(i, n)| Mutation::Number(i, n)),
        (at(), prop::sample::select(DECIMALS)).prop_map(|(i, n)| Mutation::Decimal(i, n)),
        (at(), prop::sample::select(DECIMALS)).prop_map(|(i, n)| Mutation::Decimal(i, n)),
        at().prop_map(Mutation::DropLine),
        at().prop_map(Mutation::Truncate),
    ]
}

fn apply(header: &mut Vec<u8>, mutation: &Mutation) {
    if header.is_empty() {
        return;
    }
    match mutation {
        Mutation::Byte(at, byte) => {
            let at = at.index(header.len());
            header[at] = *byte;
        }
        Mutation::Number(at, number) => {
            let at = at.index(header.len());
            for (to, from) in header[at..].iter_mut().zip(number.bytes()) {
                *to = from;
            }
        }
        Mutation::Decimal(at, number) => {
            let from = at.index(header.len());
            let Some(from) = (from..header.len()).find(|&i| header[i].is_ascii_digit()) else {
                return;
            };
            let digits = header[from..]
                .iter()
                .take_while(|b| b.is_ascii_digit())
                .count();
            header.splice(from..from + digits, number.bytes());
        }
        Mutation::DropLine(at) => {
            let at = at.index(header.len());
            let from = header[..at]
                .iter()
                .rposition(|&b| b == b'\n')
                .map_or(0, |i| i + 1);
            let to = header[at..]
                .iter()
                .position(|&b| b == b'\n')
                .map_or(header.len(), |i| at + i + 1);
            header.drain(from..to);
        }
        Mutation::Truncate(at) => {
            let at = at.index(header.len());
            header.truncate(at);
        }
    }
}

#[test]
fn the_seeds_are_well_formed() {
    let _alone = ALONE.lock();
    let folder = tempfile::tempdir().unwrap();
    for (name, header, voxels) in seeds() {
        let path = write(folder.path(), name, &header, &voxels);
        let volume = open(&path, None).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(volume.bytes(), 240, "{name}");
        assert!(volume.warnings.is_empty(), "{name}: {:?}", volume.warnings);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn mutated_headers_never_panic_nor_take_memory_that_the_file_does_not_back(
        mutations in prop::collection::vec(mutation(), 1..4),
        cut in prop::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let _alone = ALONE.lock();
        let folder = tempfile::tempdir().unwrap();
        for (name, mut header, mut voxels) in seeds() {
            for mutation in &mutations {
                apply(&mut header, mutation);
            }
            if let Some(cut) = &cut {
                voxels.truncate(cut.index(voxels.len()));
            }
            let path = write(folder.path(), name, &header, &voxels);
            let ((), peak) = peak_of(|| try_reading(&path));
            prop_assert!(peak <= BUFFERS, "{}: {} bytes", name, peak);
        }
    }
}

#[test]
fn a_header_that_declares_a_billion_voxels_over_ten_bytes_is_refused_before_memory_is_asked_for() {
    let _alone = ALONE.lock();
    let folder = tempfile::tempdir().unwrap();
    for (name, header, _) in seeds() {
        let mut huge = header;
        if ["raw.nii", "two.nii"].contains(&name) {
            for i in 1..4 {
                if name == "raw.nii" {
                    huge[40 + 2 * i..42 + 2 * i].copy_from_slice(&1000_i16.to_le_bytes());
                } else {
                    huge[16 + 8 * i..24 + 8 * i].copy_from_slice(&1000_i64.to_le_bytes());
                }
            }
        } else if name == "map.den" {
            for at in [50, 52, 54] {
                huge[at..at + 2].copy_from_slice(&1000_u16.to_le_bytes());
            }
            huge[58..62].copy_from_slice(&1_000_000_000_u32.to_le_bytes());
        } else {
            let text = String::from_utf8(huge).unwrap();
            huge = text
                .replace("6 5 4", "1000 1000 1000")
                .replace("6, 5, 4", "1000, 1000, 1000")
                .into_bytes();
        }
        let path = write(folder.path(), name, &huge, &[7; 10]);
        let ((), peak) = peak_of(|| {
            let error = open(&path, None).map(|v| v.dims).unwrap_err();
            assert!(error.is_bad_input(), "{error}");
            try_reading(&path);
        });
        assert!(peak < 2 << 20, "{name}: {peak} bytes");
    }
}

#[test]
fn a_bomb_is_refused_when_it_holds_more_than_it_declares_and_read_no_further_when_it_holds_less() {
    let _alone = ALONE.lock();
    let folder = tempfile::tempdir().unwrap();
    // 64 MiB of zeros in 64 KiB.
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::new(9));
    let zeros = vec![0_u8; 1 << 20];
    for _ in 0..64 {
        packer.write_all(&zeros).unwrap();
    }
    let bomb = packer.finish().unwrap();
    let header = |sizes: &str| {
        format!("NRRD0004\ntype: uchar\ndimension: 3\nsizes: {sizes}\nencoding: gzip\n\n")
            .into_bytes()
    };
    for (sizes, most) in [
        ("10 10 10", 2 << 20),
        ("400 400 1000", BUFFERS),
        ("1000 1000 67", 200 << 20),
    ] {
        let path = write(folder.path(), "bomb.nrrd", &header(sizes), &bomb);
        // More than deflate could make of it is refused at once; a little less than there is, at its end.
        let ((), peak) = peak_of(|| assert!(open(&path, None).unwrap_err().is_bad_input()));
        assert!(peak < most, "{sizes}: {peak} bytes");
    }
    let path = write(folder.path(), "bomb.nrrd", &header("1024 1024 64"), &bomb);
    assert_eq!(open(&path, None).unwrap().len(), 64 << 20);
}

#[test]
fn what_is_no_volume_is_refused_in_one_line() {
    let _alone = ALONE.lock();
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in [
        ("empty.nrrd", ""),
        ("empty.nii.gz", ""),
        ("empty.mha", ""),
        ("lone.img", "x"),
        ("lone.hdr", "x"),
        ("cut.nii.gz", "\u{1f}"),
        ("some.txt", "hello"),
        ("scan_4x4x4.raw", "no type in the name"),
        ("scan_4x4x4_uint8.raw", "too few bytes"),
        (
            "parts.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 2 2\nkinds: RGB-color domain domain\nencoding: raw\n\nxxxxxxxxxxxx",
        ),
        (
            "many.nhdr",
            "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 3\nencoding: raw\ndata file: LIST\n",
        ),
        (
            "gone.nhdr",
            "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 3\nencoding: raw\ndata file: gone.raw\n",
        ),
        (
            "zero.nhdr",
            "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 3\nencoding: raw\ndata file: a\0b.raw\n",
        ),
        (
            "control.nhdr",
            "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 3\nencoding: raw\ndata file: a\u{b}\u{1b}b.raw\n",
        ),
        (
            "long.mhd",
            &format!(
                "NDims = 1\nDimSize = 3\nElementType = MET_UCHAR\nElementDataFile = {}\n",
                "a".repeat(5000)
            ),
        ),
        (
            "self.nhdr",
            "NRRD0004\ntype: uchar\ndimension: 1\nsizes: 3\nencoding: raw\ndata file: .\n",
        ),
    ] {
        let path = write(folder.path(), name, content.as_bytes(), b"");
        assert!(open(&path, None).unwrap_err().is_bad_input(), "{name}");
        try_reading(&path);
    }
    for path in [folder.path(), &folder.path().join("missing.nrrd")] {
        assert!(open(path, None).unwrap_err().is_bad_input());
    }
    let layout = RawLayout::new([usize::MAX; 3], Scalar::F64);
    assert!(open(&folder.path().join("some.txt"), Some(&layout)).is_err());
    assert!(load("phantom:pot:99999999999999999999", None).is_err());
}
