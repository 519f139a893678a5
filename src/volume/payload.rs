//! The part of a file that holds voxels: where it lies, how it is packed, and reading no more of it than is there.
//!
//! Declared sizes are not trusted. Raw and text data are checked against the file's size before memory is asked for;
//! compressed data are refused where even the best compression could not yield what is declared, and memory grows only
//! with what has really been unpacked.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use memmap2::Mmap;
use rayon::prelude::*;

use super::reading::Watched;
use super::scalar::{Element, Endian};
use super::store::Store;
use crate::error::{Error, Result};

/// How voxels are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// As they are.
    Raw,
    /// Deflate in a gzip wrapper.
    Gzip,
    /// Deflate in a zlib wrapper.
    Zlib,
    /// bzip2.
    Bzip2,
    /// Decimal numbers.
    Text,
    /// Two hexadecimal digits per byte.
    Hex,
}

/// Bytes between the start of the (unpacked) data and the first voxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Skip {
    /// So many.
    Bytes(u64),
    /// The voxels are the last bytes.
    ToEnd,
}

/// Where a volume's voxels lie.
#[derive(Debug)]
pub(super) struct Payload {
    /// The file.
    pub path: PathBuf,
    /// Where packed data begin.
    pub start: u64,
    /// Lines to leave out after that, before unpacking.
    pub line_skip: u64,
    /// Bytes to leave out after unpacking.
    pub skip: Skip,
    /// How they are packed.
    pub encoding: Encoding,
}

/// A length:distance pair of deflate yields at most 258 bytes from at least two bits, hence 1032 to 1 (RFC 1951).
const DEFLATE_MAX_RATIO: u64 = 1032;
/// A bzip2 block holds at most 900,000 run-length coded bytes, five of which stand for at most 259; its headers and
/// tables alone take 20 bytes.
const BZIP2_MAX_BLOCK: u64 = 900_000 / 5 * 259;
const BZIP2_MIN_BLOCK_BYTES: u64 = 20;

/// What is asked for at first where the real size shows only by unpacking.
const FIRST_GROWTH_BYTES: usize = 1 << 20;

impl Payload {
    fn error(&self, reason: impl Into<String>) -> Error {
        Error::file(&self.path, "data", reason)
    }

    fn too_short(&self, have: u64, need: u64) -> Error {
        self.error(format!(
            "the header declares {need} bytes of voxels and the file can hold {have}"
        ))
    }

    /// The file, standing at the first packed byte, and the number of bytes from there to its end.
    fn packed(&self) -> Result<(BufReader<Watched>, u64)> {
        let io = |source| Error::io(&self.path, source);
        let (file, len) = open_file(&self.path)?;
        let mut reader = BufReader::with_capacity(1 << 17, Watched::new(file, len));
        reader.seek(SeekFrom::Start(self.start)).map_err(io)?;
        let mut position = self.start;
        for _ in 0..self.line_skip {
            let skipped = reader.skip_until(b'\n').map_err(io)?;
            if skipped == 0 {
                return Err(Error::file(
                    &self.path,
                    "line skip",
                    format!("the file has fewer than {} lines of data", self.line_skip),
                ));
            }
            position += skipped as u64;
        }
        Ok((reader, len.saturating_sub(position)))
    }

    fn unpacked(&self, packed: BufReader<Watched>) -> Box<dyn Read> {
        match self.encoding {
            Encoding::Raw | Encoding::Text | Encoding::Hex => Box::new(packed),
            Encoding::Gzip => Box::new(flate2::bufread::MultiGzDecoder::new(packed)),
            Encoding::Zlib => Box::new(flate2::bufread::ZlibDecoder::new(packed)),
            Encoding::Bzip2 => Box::new(bzip2::bufread::MultiBzDecoder::new(packed)),
        }
    }

    /// Reads `count` numbers; with `whole`, the stream must end there.
    pub(super) fn read<T: Element>(
        &self,
        count: usize,
        endian: Endian,
        whole: bool,
    ) -> Result<Vec<T>> {
        let bytes = count
            .checked_mul(size_of::<T>())
            .ok_or_else(|| self.error("the declared size exceeds what a machine can address"))?;
        let (packed, packed_len) = self.packed()?;
        let mut voxels = match self.encoding {
            Encoding::Raw => {
                let (offset, _) = self.raw_span(packed_len, bytes as u64)?;
                let mut packed = packed;
                packed
                    .seek_relative(offset as i64)
                    .map_err(|e| Error::io(&self.path, e))?;
                self.fill(&mut packed, count, count)?
            }
            Encoding::Text => return self.read_text(packed, packed_len, count),
            Encoding::Hex => self.read_hex(packed, packed_len, count)?,
            Encoding::Gzip | Encoding::Zlib | Encoding::Bzip2 => {
                self.read_packed(packed, packed_len, count, whole)?
            }
        };
        if endian != Endian::NATIVE && size_of::<T>() > 1 {
            voxels.par_iter_mut().for_each(|v: &mut T| *v = v.swapped());
        }
        Ok(voxels)
    }

    /// Offset of the first voxel from the packed start, and bytes that follow the last.
    fn raw_span(&self, len: u64, bytes: u64) -> Result<(u64, u64)> {
        let skip = match self.skip {
            Skip::Bytes(skip) => skip,
            Skip::ToEnd => len.saturating_sub(bytes),
        };
        let have = len.saturating_sub(skip);
        if have < bytes {
            return Err(self.too_short(have, bytes));
        }
        Ok((skip, have - bytes))
    }

    /// Bytes that follow the declared voxels of raw data.
    pub(super) fn raw_surplus(&self, bytes: u64) -> Result<u64> {
        if self.encoding != Encoding::Raw {
            return Ok(0);
        }
        let (_, len) = self.packed()?;
        Ok(self.raw_span(len, bytes)?.1)
    }

    fn read_packed<T: Element>(
        &self,
        packed: BufReader<Watched>,
        packed_len: u64,
        count: usize,
        whole: bool,
    ) -> Result<Vec<T>> {
        let bytes = (count * size_of::<T>()) as u64;
        let most = match self.encoding {
            Encoding::Bzip2 => (packed_len / BZIP2_MIN_BLOCK_BYTES + 1) * BZIP2_MAX_BLOCK,
            _ => packed_len.saturating_mul(DEFLATE_MAX_RATIO),
        };
        if bytes > most {
            return Err(self.too_short(most, bytes));
        }
        let skip = match self.skip {
            Skip::Bytes(skip) => skip,
            Skip::ToEnd => {
                // How much there is shows only by unpacking it: once to count, once to keep.
                let (packed, _) = self.packed()?;
                let total = io::copy(&mut self.unpacked(packed), &mut io::sink())
                    .map_err(|e| self.corrupt(&e))?;
                total
                    .checked_sub(bytes)
                    .ok_or_else(|| self.too_short(total, bytes))?
            }
        };
        let mut reader = self.unpacked(packed);
        let skipped = io::copy(&mut reader.by_ref().take(skip), &mut io::sink())
            .map_err(|e| self.corrupt(&e))?;
        if skipped < skip {
            return Err(self.too_short(0, bytes));
        }
        let first = (FIRST_GROWTH_BYTES / size_of::<T>()).min(count);
        let voxels = self.fill(&mut reader, count, first)?;
        if whole {
            // Also checks the stream's sum, which is only compared at its end.
            let surplus = reader.read(&mut [0]).map_err(|e| self.corrupt(&e))?;
            if surplus > 0 {
                return Err(self.error(format!(
                    "unpacks to more than the {bytes} bytes of voxels that the header declares"
                )));
            }
        }
        Ok(voxels)
    }

    /// Reads `count` numbers, asking for memory for `first` of them and then for as much again as has been filled.
    fn fill<T: Element>(
        &self,
        reader: &mut dyn Read,
        count: usize,
        first: usize,
    ) -> Result<Vec<T>> {
        let mut voxels: Vec<T> = Vec::new();
        while voxels.len() < count {
            let have = voxels.len();
            let more = if have == 0 { first } else { have }.min(count - have);
            voxels.try_reserve_exact(more).map_err(|_| {
                Error::Limit(format!(
                    "{}: {} bytes of memory for its voxels could not be had",
                    self.path.display(),
                    count * size_of::<T>()
                ))
            })?;
            voxels.resize(have + more, T::zeroed());
            reader
                .read_exact(bytemuck::cast_slice_mut(&mut voxels[have..]))
                .map_err(|e| {
                    if e.kind() == io::ErrorKind::UnexpectedEof {
                        self.error(format!(
                            "ends before the {} bytes of voxels that the header declares",
                            count * size_of::<T>()
                        ))
                    } else {
                        self.corrupt(&e)
                    }
                })?;
        }
        Ok(voxels)
    }

    fn corrupt(&self, error: &io::Error) -> Error {
        let packing = match self.encoding {
            Encoding::Gzip => "gzip",
            Encoding::Zlib => "zlib",
            Encoding::Bzip2 => "bzip2",
            Encoding::Raw | Encoding::Text | Encoding::Hex => "voxel",
        };
        self.error(format!(
            "the {packing} data are damaged or cut short ({error})"
        ))
    }

    /// The whole text after the header; what it takes is in the file.
    fn text(&self, mut packed: BufReader<Watched>, need: u64, have: u64) -> Result<Vec<u8>> {
        if have < need {
            return Err(self.error(format!(
                "the header declares voxels that take at least {need} characters and the file has {have}"
            )));
        }
        let mut text = Vec::new();
        packed
            .read_to_end(&mut text)
            .map_err(|e| Error::io(&self.path, e))?;
        Ok(text)
    }

    fn read_text<T: Element>(
        &self,
        packed: BufReader<Watched>,
        packed_len: u64,
        count: usize,
    ) -> Result<Vec<T>> {
        // A digit each and a character between.
        let text = self.text(packed, count as u64 * 2 - 1, packed_len)?;
        let skip = match self.skip {
            Skip::Bytes(skip) => (skip as usize).min(text.len()),
            Skip::ToEnd => {
                return Err(Error::file(&self.path, "byte skip", "-1 needs binary data"));
            }
        };
        let mut tokens = text[skip..]
            .split(|b| b.is_ascii_whitespace() || *b == b',')
            .filter(|token| !token.is_empty());
        let mut voxels = Vec::with_capacity(count);
        for token in tokens.by_ref().take(count) {
            let number = std::str::from_utf8(token).ok().and_then(T::parse);
            voxels.push(number.ok_or_else(|| {
                let token = &token[..token.len().min(40)];
                self.error(format!(
                    "\"{}\" is no number of the declared type",
                    String::from_utf8_lossy(token).escape_debug()
                ))
            })?);
        }
        if voxels.len() < count || tokens.next().is_some() {
            return Err(self.error(format!(
                "the header declares {count} numbers and the text has {}",
                if voxels.len() < count {
                    "fewer"
                } else {
                    "more"
                }
            )));
        }
        Ok(voxels)
    }

    fn read_hex<T: Element>(
        &self,
        packed: BufReader<Watched>,
        packed_len: u64,
        count: usize,
    ) -> Result<Vec<T>> {
        let bytes = count * size_of::<T>();
        let text = self.text(packed, (bytes as u64).saturating_mul(2), packed_len)?;
        let mut digits = text.iter().filter(|b| !b.is_ascii_whitespace());
        let mut digit = || {
            let byte = digits
                .next()
                .ok_or_else(|| self.error(format!("has fewer than {} hex digits", bytes * 2)))?;
            char::from(*byte)
                .to_digit(16)
                .map(|d| d as u8)
                .ok_or_else(|| self.error(format!("byte {byte} is no hex digit")))
        };
        let mut voxels = vec![T::zeroed(); count];
        for byte in bytemuck::cast_slice_mut(&mut voxels) {
            *byte = digit()? << 4 | digit()?;
        }
        Ok(voxels)
    }

    /// The voxels as a mapped file, where they lie in it just as this machine reads them.
    pub(super) fn map<T: Element>(&self, count: usize, endian: Endian) -> Result<Option<Store<T>>> {
        if self.encoding != Encoding::Raw || (endian != Endian::NATIVE && size_of::<T>() > 1) {
            return Ok(None);
        }
        let (packed, packed_len) = self.packed()?;
        let bytes = count as u64 * size_of::<T>() as u64;
        let (skip, _) = self.raw_span(packed_len, bytes)?;
        let file = packed.into_inner().into_file();
        let len = file.metadata().map_err(|e| Error::io(&self.path, e))?.len();
        let offset = (len - packed_len + skip) as usize;
        if !offset.is_multiple_of(align_of::<T>()) {
            return Ok(None);
        }
        // SAFETY: the map is read-only and private to this process's view; the range was checked against the file's
        // size just now. What remains is another process cutting the file short while it is in use, which no reader of
        // mapped files can exclude, and which ends this process with a signal instead of reading what is not there.
        // Mapping is what lets a volume larger than memory be opened at all.
        #[allow(unsafe_code)]
        let map = unsafe { Mmap::map(&file) }.map_err(|e| Error::io(&self.path, e))?;
        Ok(Some(Store::Mapped {
            map,
            offset,
            len: count,
        }))
    }
}

/// Opens a regular file and tells its size. Devices and pipes have none to check a header against.
pub(super) fn open_file(path: &Path) -> Result<(File, u64)> {
    let io = |source| Error::io(path, source);
    let metadata = path.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(Error::file(path, "file", "is not a regular file"));
    }
    Ok((File::open(path).map_err(io)?, metadata.len()))
}

/// The first bytes of a file, at most `most`.
pub(super) fn read_head(path: &Path, most: u64) -> Result<Vec<u8>> {
    let (file, _) = open_file(path)?;
    let mut head = Vec::new();
    file.take(most)
        .read_to_end(&mut head)
        .map_err(|e| Error::io(path, e))?;
    Ok(head)
}
