//! JSON written by people; errors name the keys of the value, the expected kind and the value found.

use super::extension::unmarked;
use crate::Error;
use serde::de::value::StrDeserializer;
use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, Error as _, Expected, MapAccess,
    SeqAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use serde_json::{Value, map};
use std::fmt::{Display, Formatter};

/// Most characters of a wrong text that an error shows.
const SHOWN: usize = 40;

/// Reads JSON, with or without a byte order mark.
///
/// # Errors
/// The text is no JSON: the error names line and column. A value is wrong: the error names its keys.
pub(crate) fn read<T: DeserializeOwned>(text: &[u8]) -> Result<T, Error> {
    let text = unmarked(text);
    serde_json::from_slice(text).or_else(|error| {
        let value: Value = serde_json::from_slice(text).map_err(|error| of_text(&error))?;
        T::deserialize(Reader(&value)).map_err(|wrong| Error::value(wrong.to_string()))?;
        // A `Value` keeps only one of two equal keys, so the text's error remains if the value is fine.
        Err(of_text(&error))
    })
}

/// Describes a fault of the text.
fn of_text(error: &serde_json::Error) -> Error {
    let said = error.to_string();
    let reason = said.rsplit_once(" at line").map_or(said.as_str(), |(reason, _)| reason);
    let reason = match reason {
        "expected value" => "expected a number, a text in quotes, a list or an object",
        reason if reason.starts_with("EOF") => "it ends before all brackets and quotes are closed",
        reason => reason,
    };
    let (line, column) = (error.line(), error.column());
    Error::damaged(format!("line {line}, column {column}: no JSON: {reason}"))
}

/// A wrong value.
#[derive(Debug)]
struct WrongValue {
    /// Keys and list indices that lead to the value, as `options.learn.seeds` or `inputs[2].axis`; empty for the whole.
    place: String,
    what: String,
}

impl Display for WrongValue {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        let parted = if self.place.is_empty() { "" } else { ": " };
        write!(to, "{}{parted}{}", self.place, self.what)
    }
}

impl std::error::Error for WrongValue {}

impl WrongValue {
    /// Adds an outer key or list index to the path of the error.
    fn within(mut self, outer: &str) -> Self {
        let parted = if self.place.is_empty() || self.place.starts_with('[') { "" } else { "." };
        self.place = format!("{outer}{parted}{}", self.place);
        self
    }

    fn expected(expected: &str, found: &str) -> Self {
        Self::custom(format!("expected {expected}, found {found}"))
    }
}

impl de::Error for WrongValue {
    fn custom<T: Display>(what: T) -> Self {
        Self { place: String::new(), what: what.to_string() }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::expected(&named(expected), &shown(found))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(len: usize, expected: &dyn Expected) -> Self {
        Self::expected(&named(expected), &format!("a list of {len}"))
    }

    fn unknown_variant(found: &str, expected: &'static [&'static str]) -> Self {
        Self::expected(&one_of(expected), &format!("\"{found}\""))
    }

    fn unknown_field(found: &str, expected: &'static [&'static str]) -> Self {
        Self::custom(format!("unknown key \"{found}\": expected {}", one_of(expected)))
    }

    fn missing_field(key: &'static str) -> Self {
        Self::custom(format!("there is no `{key}`"))
    }
}

fn one_of(all: &[&str]) -> String {
    format!("one of {}", all.join(", "))
}

/// Describes an expected type without the names of Rust.
fn named(expected: &dyn Expected) -> String {
    let said = expected.to_string();
    match said.as_str() {
        "f32" | "f64" => "a number".to_owned(),
        "u32" | "u64" | "usize" => "a whole number that is not negative".to_owned(),
        "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a boolean" => "true or false".to_owned(),
        _ => said.replace("an array of length", "a list of"),
    }
}

/// Describes a wrong value; shortens a long text.
fn shown(found: Unexpected<'_>) -> String {
    match found {
        Unexpected::Bool(found) => found.to_string(),
        Unexpected::Unsigned(found) => found.to_string(),
        Unexpected::Signed(found) => found.to_string(),
        Unexpected::Float(found) => found.to_string(),
        Unexpected::Str(found) => match found.char_indices().nth(SHOWN) {
            Some((end, _)) => format!("\"{} ...\"", &found[..end]),
            None => format!("\"{found}\""),
        },
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "an object".to_owned(),
        Unexpected::Unit => "null".to_owned(),
        other => other.to_string(),
    }
}

/// Reads a value and keeps track of its path for errors.
struct Reader<'a>(&'a Value);

impl<'a> Reader<'a> {
    fn found(&self) -> Unexpected<'a> {
        match self.0 {
            Value::Null => Unexpected::Unit,
            Value::Bool(found) => Unexpected::Bool(*found),
            Value::Number(found) => {
                found.as_f64().map_or(Unexpected::Other("a number"), Unexpected::Float)
            }
            Value::String(found) => Unexpected::Str(found),
            Value::Array(_) => Unexpected::Seq,
            Value::Object(_) => Unexpected::Map,
        }
    }
}

impl<'a> Deserializer<'a> for Reader<'a> {
    type Error = WrongValue;

    fn deserialize_any<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, WrongValue> {
        match self.0 {
            Value::Null => visitor.visit_unit(),
            Value::Bool(own) => visitor.visit_bool(*own),
            Value::Number(own) => match (own.as_u64(), own.as_i64(), own.as_f64()) {
                (Some(own), ..) => visitor.visit_u64(own),
                (None, Some(own), _) => visitor.visit_i64(own),
                (None, None, own) => visitor.visit_f64(own.unwrap_or(f64::NAN)),
            },
            Value::String(own) => visitor.visit_borrowed_str(own),
            Value::Array(own) => visitor.visit_seq(Items { left: own.iter().enumerate() }),
            Value::Object(own) => visitor.visit_map(Fields { left: own.iter(), value: None }),
        }
    }

    fn deserialize_option<V: Visitor<'a>>(self, visitor: V) -> Result<V::Value, WrongValue> {
        if self.0.is_null() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_newtype_struct<V: Visitor<'a>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, WrongValue> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'a>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, WrongValue> {
        match self.0 {
            Value::Object(_) => self.deserialize_any(visitor),
            _ => Err(de::Error::invalid_type(self.found(), &visitor)),
        }
    }

    fn deserialize_enum<V: Visitor<'a>>(
        self,
        _: &'static str,
        all: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, WrongValue> {
        match self.0 {
            Value::String(own) => visitor.visit_enum(StrDeserializer::<WrongValue>::new(own)),
            _ => Err(WrongValue::expected(&one_of(all), &shown(self.found()))),
        }
    }

    forward_to_deserialize_any! {
        <V: Visitor<'a>>
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// The remaining values of a list.
struct Items<'a> {
    left: std::iter::Enumerate<std::slice::Iter<'a, Value>>,
}

impl<'a> SeqAccess<'a> for Items<'a> {
    type Error = WrongValue;

    fn next_element_seed<T: DeserializeSeed<'a>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, WrongValue> {
        let Some((at, value)) = self.left.next() else { return Ok(None) };
        seed.deserialize(Reader(value)).map(Some).map_err(|error| error.within(&format!("[{at}]")))
    }
}

/// The remaining keys and values of an object.
struct Fields<'a> {
    left: map::Iter<'a>,
    /// The pair whose key was read last.
    value: Option<(&'a String, &'a Value)>,
}

impl<'a> MapAccess<'a> for Fields<'a> {
    type Error = WrongValue;

    fn next_key_seed<T: DeserializeSeed<'a>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, WrongValue> {
        self.value = self.left.next();
        let Some((key, _)) = self.value else { return Ok(None) };
        seed.deserialize(StrDeserializer::<WrongValue>::new(key)).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'a>>(&mut self, seed: T) -> Result<T::Value, WrongValue> {
        let Some((key, value)) = self.value.take() else {
            return Err(de::Error::custom("a key without a value"));
        };
        seed.deserialize(Reader(value)).map_err(|error| error.within(key))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Way {
        Up,
        Down,
    }

    #[derive(Debug, Default, Deserialize)]
    #[serde(default, deny_unknown_fields, expecting = "an object with `list`")]
    struct Inner {
        number: Option<f64>,
        count: usize,
        whole: i32,
        flag: bool,
        way: Option<Way>,
        ends: Option<[f64; 2]>,
        list: Vec<Inner>,
        text: String,
    }

    #[derive(Debug, Deserialize)]
    #[serde(expecting = "an object with `inner`")]
    struct Outer {
        inner: Inner,
    }

    fn message_of(text: &str) -> String {
        read::<Outer>(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn values_are_read_with_a_mark_or_without() {
        let text = r#"{"inner": {"number": 1, "whole": -2, "way": "down", "ends": [0, 1.5], "text": "a"}}"#;
        for text in [text.to_owned(), format!("\u{feff}{text}")] {
            let Inner { number, whole, way, ends, text, .. } =
                read::<Outer>(text.as_bytes()).unwrap().inner;
            assert_eq!((number, whole, ends), (Some(1.0), -2, Some([0.0, 1.5])));
            assert!(matches!(way, Some(Way::Down)) && text == "a");
        }
    }

    #[test]
    fn a_wrong_value_is_named_by_its_keys_in_plain_words() {
        for (inner, expected) in [
            (r#"{"number": "1"}"#, "inner.number: expected a number, found \"1\""),
            (r#"{"number": [1]}"#, "inner.number: expected a number, found a list"),
            (
                r#"{"count": -1}"#,
                "inner.count: expected a whole number that is not negative, found -1",
            ),
            (
                r#"{"count": 1.5}"#,
                "inner.count: expected a whole number that is not negative, found 1.5",
            ),
            (r#"{"whole": null}"#, "inner.whole: expected a whole number, found null"),
            (r#"{"flag": 1}"#, "inner.flag: expected true or false, found 1"),
            (r#"{"way": "Up"}"#, "inner.way: expected one of up, down, found \"Up\""),
            (r#"{"way": 3}"#, "inner.way: expected one of up, down, found 3"),
            (r#"{"ends": [1]}"#, "inner.ends: expected a list of 2, found a list of 1"),
            (r#"{"text": {}}"#, "inner.text: expected a text in quotes, found an object"),
            (r#"{"list": {}}"#, "inner.list: expected a list, found an object"),
            (
                r#"{"list": [{}, {"count": true}]}"#,
                "inner.list[1].count: expected a whole number that is not negative, found true",
            ),
            ("[[1]]", "inner: expected an object with `list`, found a list"),
            (
                r#"{"cuont": 1}"#,
                "inner: unknown key \"cuont\": expected one of number, count, whole, flag, way, ends, list, text",
            ),
        ] {
            assert_eq!(message_of(&format!("{{\"inner\": {inner}}}")), expected);
        }
        assert_eq!(message_of("{}"), "there is no `inner`");
        assert_eq!(message_of("[3]"), "expected an object with `inner`, found a list");
    }

    #[test]
    fn a_wrong_text_is_named_by_line_and_column() {
        for (text, expected) in [
            ("", "line 1, column 0: no JSON: it ends before all brackets and quotes are closed"),
            (
                "{\n\"inner\": NaN}",
                "line 2, column 10: no JSON: expected a number, a text in quotes, a list or an object",
            ),
            ("{\"inner\": {},}", "line 1, column 14: no JSON: trailing comma"),
            (
                "{\"inner\": {}, \"inner\": {}}",
                "line 1, column 21: no JSON: duplicate field `inner`",
            ),
        ] {
            assert_eq!(message_of(text), expected);
        }
    }
}
