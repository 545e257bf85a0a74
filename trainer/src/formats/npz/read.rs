//! Reads arrays of any number type out of an npz archive, one pass, without a second copy.

use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read};
use std::path::Path;

use npyz::npz::file_name_from_array_name;
use npyz::{DType, Deserialize, NpyFile, NpyHeader, Order, TypeChar};
use zip::ZipArchive;

use super::error::ArrayError;
use crate::formats::error::FormatError;

/// An open npz archive.
pub(crate) struct Archive {
    zip: ZipArchive<BufReader<File>>,
}

/// An array as rows of K numbers in C order.
pub(crate) struct Rows<T, const K: usize> {
    /// Counts of the dimensions before those that make a row.
    pub(crate) lead: Vec<usize>,
    /// The rows.
    pub(crate) data: Vec<[T; K]>,
}

/// A number that arrays are read into.
pub(crate) trait Number: Copy + Default {
    /// The numbers of an array that can be read into it, in words.
    const EXPECTED: &'static str;

    /// Hands every number of the file to `store`, or gives `None` for another type.
    fn each(file: NpyFile<impl Read>, store: impl FnMut(Self)) -> Option<io::Result<()>>;
}

/// Reads a `.npy` file of one row of numbers, called `array` where something is wrong with it.
pub(crate) fn read_npy(path: &Path, array: &str) -> Result<Vec<f64>, FormatError> {
    let array = || array.to_owned();
    let damaged = |reason: &str| ArrayError::Damaged { array: array(), reason: reason.to_owned() };
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    let mut left = bytes.as_slice();
    let header =
        NpyHeader::from_reader(&mut left).map_err(|error| damaged(fault_of_header(&error)))?;
    if header.shape().len() != 1 {
        let found = header.shape().to_vec();
        let expected = "[n]".to_owned();
        return Err(ArrayError::WrongShape { array: array(), expected, found }.into());
    }
    let found = header.dtype().descr();
    let wrong = ArrayError::WrongType { array: array(), expected: f64::EXPECTED, found };
    let mut numbers = Vec::new();
    let read = f64::each(NpyFile::with_header(header, left), |number| numbers.push(number));
    read.ok_or(wrong)?.map_err(|error| damaged(fault_of_data(&error)))?;
    Ok(numbers)
}

impl Archive {
    /// Opens an archive and reads its directory.
    pub(crate) fn open(path: &Path) -> Result<Self, FormatError> {
        let file = File::open(path).map_err(FormatError::Read)?;
        let found = file.metadata().map_err(FormatError::Read)?.len();
        let zip =
            ZipArchive::new(BufReader::new(file)).map_err(|_| ArrayError::Archive { found })?;
        Ok(Self { zip })
    }

    /// Returns whether there is such an array.
    pub(crate) fn has(&self, array: &str) -> bool {
        self.zip.index_for_name(&file_name_from_array_name(array)).is_some()
    }

    /// Reads an array as [`Archive::rows`] does, and insists on it.
    pub(crate) fn required<T: Number, const K: usize>(
        &mut self,
        array: &'static str,
        tail: &[u64],
    ) -> Result<Rows<T, K>, FormatError> {
        Ok(self.rows(array, tail)?.ok_or(ArrayError::Missing { array })?)
    }

    /// Reads an array of shape `[any, tail..]`, where 0 in `tail` is any count too and the counts
    /// after the last 0 multiply to K. `None` if there is no such array.
    pub(crate) fn rows<T: Number, const K: usize>(
        &mut self,
        array: &str,
        tail: &[u64],
    ) -> Result<Option<Rows<T, K>>, FormatError> {
        let Some((header, mut file)) = self.find(array)? else { return Ok(None) };
        let shape = header.shape();
        let fits = shape.len() == tail.len() + 1
            && shape[1..].iter().zip(tail).all(|(&found, &wanted)| wanted == 0 || found == wanted);
        if !fits {
            let tail = tail.iter().map(|&n| if n == 0 { ", n".into() } else { format!(", {n}") });
            return Err(ArrayError::WrongShape {
                array: array.to_owned(),
                expected: format!("[n{}]", tail.collect::<String>()),
                found: shape.to_vec(),
            }
            .into());
        }
        let lead_len = 1 + tail.iter().filter(|&&count| count == 0).count();
        let lead: Vec<usize> = shape[..lead_len].iter().map(|&count| count as usize).collect();

        let damaged = |reason: String| ArrayError::Damaged { array: array.to_owned(), reason };
        // `find` has compared the count with the bytes that are there.
        let row_len: usize = lead.iter().product();
        let mut data = Vec::new();
        data.try_reserve_exact(row_len).map_err(|error| damaged(error.to_string()))?;
        data.resize(row_len, [T::default(); K]);
        let mut places = Places::new(&header);
        let flat = data.as_flattened_mut();
        let wrong = ArrayError::WrongType {
            array: array.to_owned(),
            expected: T::EXPECTED,
            found: header.dtype().descr(),
        };
        T::each(NpyFile::with_header(header, &mut file), |number| flat[places.take()] = number)
            .ok_or(wrong)?
            .and_then(|()| finish(file))
            .map_err(|error| damaged(fault_of_data(&error).to_owned()))?;
        Ok(Some(Rows { lead, data }))
    }

    /// Reads one number, with or without a dimension of one. `None` if there is no such array.
    pub(crate) fn number(&mut self, array: &str) -> Result<Option<f64>, FormatError> {
        let Some((header, mut file)) = self.find(array)? else { return Ok(None) };
        check_one(array, &header)?;
        let found = header.dtype().descr();
        let wrong =
            ArrayError::WrongType { array: array.to_owned(), expected: f64::EXPECTED, found };
        let mut only = f64::NAN;
        let damaged = |error: io::Error| ArrayError::Damaged {
            array: array.to_owned(),
            reason: fault_of_data(&error).to_owned(),
        };
        f64::each(NpyFile::with_header(header, &mut file), |number| only = number)
            .ok_or(wrong)?
            .and_then(|()| finish(file))
            .map_err(damaged)?;
        Ok(Some(only))
    }

    /// Reads a list of texts. `None` if there is no such array.
    pub(crate) fn texts(&mut self, array: &str) -> Result<Option<Vec<String>>, FormatError> {
        let Some((header, file)) = self.find(array)? else { return Ok(None) };
        if header.shape().len() != 1 {
            let (array, expected) = (array.to_owned(), "[n]".to_owned());
            let found = header.shape().to_vec();
            return Err(ArrayError::WrongShape { array, expected, found }.into());
        }
        texts(array, header, file).map(Some)
    }

    /// Reads one text, with or without a dimension of one. `None` if there is no such array.
    pub(crate) fn text(&mut self, array: &str) -> Result<Option<String>, FormatError> {
        let Some((header, file)) = self.find(array)? else { return Ok(None) };
        check_one(array, &header)?;
        Ok(texts(array, header, file)?.pop())
    }

    /// Finds an array and checks that its header asks for no more bytes than there are.
    fn find(&mut self, array: &str) -> Result<Option<(NpyHeader, impl Read + '_)>, FormatError> {
        let damaged = |reason: String| ArrayError::Damaged { array: array.to_owned(), reason };
        let Some(index) = self.zip.index_for_name(&file_name_from_array_name(array)) else {
            return Ok(None);
        };
        let unpacked = self.zip.by_index(index);
        let mut file = unpacked.map_err(|_| damaged("it cannot be unpacked".to_owned()))?;
        let present = file.size();
        let header = NpyHeader::from_reader(&mut file)
            .map_err(|error| damaged(fault_of_header(&error).to_owned()))?;
        let each = header.dtype().num_bytes().map_or(1, |bytes| bytes as u64);
        let count = header.shape().iter().try_fold(1, |all: u64, &count| all.checked_mul(count));
        let asked = count.and_then(|count| count.checked_mul(each));
        match asked {
            Some(asked) if asked <= present => Ok(Some((header, BufReader::new(file)))),
            _ => Err(damaged(format!(
                "shape {:?} asks for more than its {present} bytes",
                header.shape()
            ))
            .into()),
        }
    }
}

/// Checks that an array holds one thing, with or without a dimension.
fn check_one(array: &str, header: &NpyHeader) -> Result<(), ArrayError> {
    match header.shape() {
        [] | [1] => Ok(()),
        found => Err(ArrayError::WrongShape {
            array: array.to_owned(),
            expected: "[] or [1]".to_owned(),
            found: found.to_vec(),
        }),
    }
}

/// Reads the texts of an array to the end of its file.
fn texts(array: &str, header: NpyHeader, mut file: impl Read) -> Result<Vec<String>, FormatError> {
    let found = header.dtype().descr();
    let texts = NpyFile::with_header(header, &mut file)
        .data::<String>()
        .map_err(|_| ArrayError::WrongType { array: array.to_owned(), expected: "text", found })?;
    let texts = texts.collect::<io::Result<_>>().and_then(|texts| finish(file).map(|()| texts));
    let damaged = |error: io::Error| ArrayError::Damaged {
        array: array.to_owned(),
        reason: fault_of_data(&error).to_owned(),
    };
    Ok(texts.map_err(damaged)?)
}

/// Names the fault of an array's header.
fn fault_of_header(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::UnexpectedEof => "it ends in its header",
        _ => "its header is not that of an .npy array of numbers or text",
    }
}

/// Names the fault of an array's numbers or texts.
fn fault_of_data(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::UnexpectedEof => "it ends early",
        _ => "its bytes do not match their checksum",
    }
}

/// Reads on to the end of an array's file, where zip compares its checksum.
fn finish(mut file: impl Read) -> io::Result<()> {
    io::copy(&mut file, &mut io::sink()).map(drop)
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
            // A count beyond i64 is out of any range: the largest i64 says so as well.
            (TypeChar::Uint, 8) => {
                each(file, |number: u64| store(number.try_into().unwrap_or(i64::MAX)))
            }
            _ => None,
        }
    }
}

fn plain(file: &NpyHeader) -> Option<(TypeChar, u64)> {
    match file.dtype() {
        DType::Plain(kind) => Some((kind.type_char(), kind.size_field())),
        _ => None,
    }
}

fn each<T: Deserialize>(
    file: NpyFile<impl Read>,
    mut store: impl FnMut(T),
) -> Option<io::Result<()>> {
    let mut numbers = file.data().ok()?;
    Some(numbers.try_for_each(|number| number.map(&mut store)))
}

/// Where the next number of a file stands in C order.
struct Places {
    /// (count, stride in C order) of each dimension, fastest in the file first.
    dimensions: Vec<(usize, usize)>,
    index: Vec<usize>,
    next: usize,
}

impl Places {
    fn new(header: &NpyHeader) -> Self {
        let mut stride = 1;
        let mut dimensions = Vec::new();
        for &count in header.shape().iter().rev() {
            dimensions.push((count as usize, stride));
            stride *= count as usize;
        }
        if header.order() == Order::Fortran {
            dimensions.reverse();
        }
        Self { index: vec![0; dimensions.len()], dimensions, next: 0 }
    }

    fn take(&mut self) -> usize {
        let place = self.next;
        for (index, &(count, stride)) in self.index.iter_mut().zip(&self.dimensions) {
            *index += 1;
            self.next += stride;
            if *index < count {
                break;
            }
            self.next -= count * stride;
            *index = 0;
        }
        place
    }
}
