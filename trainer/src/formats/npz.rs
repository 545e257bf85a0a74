//! Arrays of NumPy: reads and writes `.npz` archives, and reads `.npy` files.
//!
//! Arrays of any number type are read in one pass, without a second copy. Writing equal arrays gives equal bytes.

use super::extension::{extension, unknown_format};
use crate::Error;
use npyz::npz::file_name_from_array_name;
use npyz::{
    AutoSerialize, DType, Deserialize, NpyFile, NpyHeader, Order, TypeChar, WriteOptions,
    WriterBuilder,
};
use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{System, ZipArchive, ZipWriter};

/// Compressed, larger than 4 GB if needed, and equal everywhere: with a fixed date and system.
const OPTIONS: SimpleFileOptions = SimpleFileOptions::DEFAULT.large_file(true).system(System::Unix);

/// An open npz archive.
pub(crate) struct Archive(ZipArchive<BufReader<File>>);

/// An array as rows of K numbers in C order.
pub(crate) struct Rows<T, const K: usize> {
    /// Sizes of the dimensions before those that form a row.
    pub(crate) lead: Vec<usize>,
    /// The rows.
    pub(crate) data: Vec<[T; K]>,
}

/// A number type that arrays are read into.
pub(crate) trait Number: Copy + Default {
    /// The numbers that can be converted to this type, in words.
    const EXPECTED: &'static str;

    /// Passes every number of the file to `store`; returns `None` if the file has another type.
    fn each(file: NpyFile<impl Read>, store: impl FnMut(Self)) -> Option<io::Result<()>>;
}

/// Reads a `.npy` file of one dimension; errors call it `array`.
pub(crate) fn read_npy(path: &Path, array: &str) -> Result<Vec<f64>, Error> {
    let bytes = std::fs::read(path).map_err(Error::read)?;
    let mut left = bytes.as_slice();
    let header = NpyHeader::from_reader(&mut left)
        .map_err(|error| damaged(array, fault_of_header(&error)))?;
    if header.shape().len() != 1 {
        return Err(wrong_shape(array, "[n]", header.shape()));
    }
    let mut numbers = Vec::new();
    read_each(array, header, left, |number| numbers.push(number))?;
    Ok(numbers)
}

/// Reads the numbers of a `.npy`, `.txt` or `.csv` file; errors call them `array`.
pub(crate) fn read_numbers(path: &Path, array: &str) -> Result<Vec<f64>, Error> {
    match extension(path).as_str() {
        "npy" => read_npy(path, array),
        "txt" | "csv" => {
            let text = std::fs::read_to_string(path).map_err(Error::read)?;
            let numbers = text.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
            let numbers = numbers.filter(|word| !word.is_empty());
            let parse = |(place, word): (usize, &str)| {
                word.parse().map_err(|_| {
                    Error::value(format!(
                        "array {array} has {word:?} as number {place}, expected a number"
                    ))
                })
            };
            numbers.enumerate().map(parse).collect()
        }
        _ => Err(unknown_format(path, ".npy, .txt or .csv")),
    }
}

impl Archive {
    /// Opens an archive and reads its directory.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(Error::read)?;
        let found = file.metadata().map_err(Error::read)?.len();
        let cut = |_| {
            Error::damaged(format!(
                "is no whole .npz archive: its {found} bytes do not end with the archive's directory; \
                 write it, or copy it, again"
            ))
        };
        ZipArchive::new(BufReader::new(file)).map_err(cut).map(Self)
    }

    /// Returns whether the archive has the array.
    pub(crate) fn has(&self, array: &str) -> bool {
        self.0.index_for_name(&file_name_from_array_name(array)).is_some()
    }

    /// Reads an array as [`Archive::rows`] does; a missing array is an error.
    pub(crate) fn required<T: Number, const K: usize>(
        &mut self,
        array: &'static str,
        tail: &[u64],
    ) -> Result<Rows<T, K>, Error> {
        self.rows(array, tail)?.ok_or_else(|| missing(array))
    }

    /// Reads an array of shape `[any, tail..]`; `None` if the archive has no such array.
    ///
    /// A 0 in `tail` means any count; the counts after the last 0 multiply to K.
    pub(crate) fn rows<T: Number, const K: usize>(
        &mut self,
        array: &str,
        tail: &[u64],
    ) -> Result<Option<Rows<T, K>>, Error> {
        let Some((header, file)) = self.find(array)? else { return Ok(None) };
        let shape = header.shape();
        let fits = shape.len() == tail.len() + 1
            && shape[1..].iter().zip(tail).all(|(&found, &wanted)| wanted == 0 || found == wanted);
        if !fits {
            let tail = tail.iter().map(|&n| if n == 0 { ", n".into() } else { format!(", {n}") });
            let expected = format!("[n{}]", tail.collect::<String>());
            return Err(wrong_shape(array, &expected, shape));
        }
        let lead_len = 1 + tail.iter().filter(|&&count| count == 0).count();
        let lead: Vec<usize> = shape[..lead_len].iter().map(|&count| count as usize).collect();

        // `find` has checked that the file has enough bytes for this count.
        let row_len: usize = lead.iter().product();
        let mut data = Vec::new();
        data.try_reserve_exact(row_len).map_err(|error| damaged(array, error))?;
        data.resize(row_len, [T::default(); K]);
        let mut places = places(&header);
        let flat = data.as_flattened_mut();
        read_each(array, header, file, |number| flat[places()] = number)?;
        Ok(Some(Rows { lead, data }))
    }

    /// Reads one number, stored as a scalar or as an array of one; `None` if the archive has no such array.
    pub(crate) fn number(&mut self, array: &str) -> Result<Option<f64>, Error> {
        let Some((header, file)) = self.find(array)? else { return Ok(None) };
        check_one(array, &header)?;
        let mut only = f64::NAN;
        read_each(array, header, file, |number| only = number)?;
        Ok(Some(only))
    }

    /// Reads a list of texts; `None` if the archive has no such array.
    pub(crate) fn texts(&mut self, array: &str) -> Result<Option<Vec<String>>, Error> {
        let Some((header, file)) = self.find(array)? else { return Ok(None) };
        if header.shape().len() != 1 {
            return Err(wrong_shape(array, "[n]", header.shape()));
        }
        texts(array, header, file).map(Some)
    }

    /// Reads one text, stored as a scalar or as an array of one; `None` if the archive has no such array.
    pub(crate) fn text(&mut self, array: &str) -> Result<Option<String>, Error> {
        let Some((header, file)) = self.find(array)? else { return Ok(None) };
        check_one(array, &header)?;
        Ok(texts(array, header, file)?.pop())
    }

    /// Finds an array and checks that the file has enough bytes for the header's shape.
    fn find(&mut self, array: &str) -> Result<Option<(NpyHeader, impl Read + '_)>, Error> {
        let Some(index) = self.0.index_for_name(&file_name_from_array_name(array)) else {
            return Ok(None);
        };
        let unpacked = self.0.by_index(index);
        let mut file = unpacked.map_err(|_| damaged(array, "it cannot be unpacked"))?;
        let present = file.size();
        let header = NpyHeader::from_reader(&mut file)
            .map_err(|error| damaged(array, fault_of_header(&error)))?;
        let each = header.dtype().num_bytes().map_or(1, |bytes| bytes as u64);
        let count = header.shape().iter().try_fold(1, |all: u64, &count| all.checked_mul(count));
        let asked = count.and_then(|count| count.checked_mul(each));
        match asked {
            Some(asked) if asked <= present => Ok(Some((header, BufReader::new(file)))),
            _ => {
                let shape = header.shape();
                let reason = format!("shape {shape:?} asks for more than its {present} bytes");
                Err(damaged(array, reason))
            }
        }
    }
}

impl Number for f64 {
    const EXPECTED: &'static str = "numbers";

    fn each(file: NpyFile<impl Read>, mut store: impl FnMut(Self)) -> Option<io::Result<()>> {
        match plain(&file)? {
            (TypeChar::Float, 2) => each(file, |number: half::f16| store(number.into())),
            (TypeChar::Float, 4) => each(file, |number: f32| store(number.into())),
            (TypeChar::Float, 8) => each(file, store),
            _ => i64::each(file, |number| store(number as f64)),
        }
    }
}

impl Number for i64 {
    const EXPECTED: &'static str = "whole numbers";

    fn each(file: NpyFile<impl Read>, mut store: impl FnMut(Self)) -> Option<io::Result<()>> {
        match plain(&file)? {
            (TypeChar::Int, 1) => each(file, |number: i8| store(number.into())),
            (TypeChar::Int, 2) => each(file, |number: i16| store(number.into())),
            (TypeChar::Int, 4) => each(file, |number: i32| store(number.into())),
            (TypeChar::Int, 8) => each(file, store),
            (TypeChar::Uint, 1) => each(file, |number: u8| store(number.into())),
            (TypeChar::Uint, 2) => each(file, |number: u16| store(number.into())),
            (TypeChar::Uint, 4) => each(file, |number: u32| store(number.into())),
            // A count above i64 is out of any range, and so is the largest i64.
            (TypeChar::Uint, 8) => {
                each(file, |number: u64| store(number.try_into().unwrap_or(i64::MAX)))
            }
            _ => None,
        }
    }
}

/// An npz archive under construction.
pub(crate) struct Writer<'a>(ZipWriter<BufWriter<&'a mut File>>);

impl<'a> Writer<'a> {
    /// Begins an archive in an empty file.
    pub(crate) fn new(file: &'a mut File) -> Self {
        Self(ZipWriter::new(BufWriter::new(file)))
    }

    /// Adds an array of numbers in C order; their count must fill `shape`.
    pub(crate) fn numbers<T: AutoSerialize>(
        &mut self,
        array: &str,
        shape: &[u64],
        numbers: impl Iterator<Item = T>,
    ) -> io::Result<()> {
        self.0.start_file(file_name_from_array_name(array), OPTIONS)?;
        let options = WriteOptions::new().default_dtype().shape(shape);
        let mut file = options.writer(&mut self.0).begin_nd()?;
        file.extend(numbers)?;
        file.finish()
    }

    /// Adds a list of texts.
    pub(crate) fn texts(&mut self, array: &str, texts: &[String]) -> io::Result<()> {
        let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
        let invalid = |_| io::Error::from(io::ErrorKind::InvalidInput);
        let dtype = DType::Plain(format!("<U{longest}").parse().map_err(invalid)?);
        let shape = [texts.len() as u64];
        self.0.start_file(file_name_from_array_name(array), OPTIONS)?;
        let options = WriteOptions::<str>::new().dtype(dtype).shape(&shape);
        let mut file = options.writer(&mut self.0).begin_nd()?;
        for text in texts {
            file.push(text)?;
        }
        file.finish()
    }

    /// Ends the archive.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.0.finish()?.flush()
    }
}

/// Checks that an array holds a single item, as a scalar or as an array of one.
fn check_one(array: &str, header: &NpyHeader) -> Result<(), Error> {
    match header.shape() {
        [] | [1] => Ok(()),
        found => Err(wrong_shape(array, "[] or [1]", found)),
    }
}

/// Passes every number of an array to `store`, and reads to the end of its file.
fn read_each<T: Number>(
    array: &str,
    header: NpyHeader,
    mut file: impl Read,
    store: impl FnMut(T),
) -> Result<(), Error> {
    let wrong = wrong_type(array, T::EXPECTED, &header);
    let read = T::each(NpyFile::with_header(header, &mut file), store).ok_or(wrong)?;
    read.and_then(|()| finish(file)).map_err(|error| damaged(array, fault_of_data(&error)))
}

/// Reads the texts of an array to the end of its file.
fn texts(array: &str, header: NpyHeader, mut file: impl Read) -> Result<Vec<String>, Error> {
    let wrong = wrong_type(array, "text", &header);
    let texts = NpyFile::with_header(header, &mut file).data::<String>().map_err(|_| wrong)?;
    let texts = texts.collect::<io::Result<_>>().and_then(|texts| finish(file).map(|()| texts));
    texts.map_err(|error| damaged(array, fault_of_data(&error)))
}

/// Makes the error for an archive without a required array.
///
/// - `array`: name of the array; several names if any of them suffices.
pub(crate) fn missing(array: &str) -> Error {
    Error::missing(format!("array {array} is missing"))
}

fn damaged(array: &str, reason: impl Display) -> Error {
    Error::damaged(format!("array {array} is damaged: {reason}; write the file, or copy it, again"))
}

fn wrong_type(array: &str, expected: &str, header: &NpyHeader) -> Error {
    let found = header.dtype().descr();
    Error::value(format!("array {array} must hold {expected}, found dtype {found}"))
}

/// Makes the error for an array of another shape; a letter in `expected` means any count.
fn wrong_shape(array: &str, expected: &str, found: &[u64]) -> Error {
    Error::value(format!("array {array} must have shape {expected}, found {found:?}"))
}

/// Describes the fault of an array's header.
fn fault_of_header(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::UnexpectedEof => "it ends in its header",
        _ => "its header is not that of an .npy array of numbers or text",
    }
}

/// Describes the fault of an array's data.
fn fault_of_data(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::UnexpectedEof => "it ends early",
        _ => "its bytes do not match their checksum",
    }
}

/// Reads to the end of an array's file, where the zip reader compares the checksum.
fn finish(mut file: impl Read) -> io::Result<()> {
    io::copy(&mut file, &mut io::sink()).map(drop)
}

/// Returns the type and size of plain numbers; `None` for other types.
fn plain(file: &NpyHeader) -> Option<(TypeChar, u64)> {
    match file.dtype() {
        DType::Plain(kind) => Some((kind.type_char(), kind.size_field())),
        _ => None,
    }
}

/// Passes every number of a file of type T to `store`; `None` if the file has another type.
fn each<T: Deserialize>(
    file: NpyFile<impl Read>,
    mut store: impl FnMut(T),
) -> Option<io::Result<()>> {
    let mut numbers = file.data().ok()?;
    Some(numbers.try_for_each(|number| number.map(&mut store)))
}

/// Returns the position in C order of each successive number of a file, one a call.
fn places(header: &NpyHeader) -> impl FnMut() -> usize + use<> {
    let mut stride = 1;
    // (index, count, stride in C order) of each dimension, fastest in the file first.
    let mut dimensions = Vec::new();
    for &count in header.shape().iter().rev() {
        dimensions.push((0, count as usize, stride));
        stride *= count as usize;
    }
    if header.order() == Order::Fortran {
        dimensions.reverse();
    }
    let mut next = 0;
    move || {
        let place = next;
        for (index, count, stride) in &mut dimensions {
            *index += 1;
            next += *stride;
            if *index < *count {
                break;
            }
            next -= *count * *stride;
            *index = 0;
        }
        place
    }
}
