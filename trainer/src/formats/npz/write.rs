//! Writes arrays into an npz archive. The same arrays give the same bytes.

use std::fs::File;
use std::io::{self, BufWriter, Write};

use npyz::npz::file_name_from_array_name;
use npyz::{AutoSerialize, DType, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{System, ZipWriter};

/// Compressed, able to pass 4 GB, and the same everywhere: dated 1980, and from one system.
const OPTIONS: SimpleFileOptions = SimpleFileOptions::DEFAULT.large_file(true).system(System::Unix);

/// An npz archive that is being written.
pub(crate) struct Writer<'a> {
    zip: ZipWriter<BufWriter<&'a mut File>>,
}

impl<'a> Writer<'a> {
    /// Begins an archive in an empty file.
    pub(crate) fn new(file: &'a mut File) -> Self {
        Self { zip: ZipWriter::new(BufWriter::new(file)) }
    }

    /// Adds an array of numbers in C order, as many as fill `shape`.
    pub(crate) fn numbers<T: AutoSerialize>(
        &mut self,
        array: &str,
        shape: &[u64],
        numbers: impl Iterator<Item = T>,
    ) -> io::Result<()> {
        self.zip.start_file(file_name_from_array_name(array), OPTIONS)?;
        let options = WriteOptions::new().default_dtype().shape(shape);
        let mut file = options.writer(&mut self.zip).begin_nd()?;
        file.extend(numbers)?;
        file.finish()
    }

    /// Adds a list of texts.
    pub(crate) fn texts(&mut self, array: &str, texts: &[String]) -> io::Result<()> {
        let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
        let invalid = |_| io::Error::from(io::ErrorKind::InvalidInput);
        let dtype = DType::Plain(format!("<U{longest}").parse().map_err(invalid)?);
        let shape = [texts.len() as u64];
        self.zip.start_file(file_name_from_array_name(array), OPTIONS)?;
        let options = WriteOptions::<str>::new().dtype(dtype).shape(&shape);
        let mut file = options.writer(&mut self.zip).begin_nd()?;
        for text in texts {
            file.push(text)?;
        }
        file.finish()
    }

    /// Ends the archive.
    pub(crate) fn finish(self) -> io::Result<()> {
        self.zip.finish()?.flush()
    }
}
