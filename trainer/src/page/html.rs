//! Parts of a page as HTML: text, tables, pictures.

use super::picture::Picture;
use crate::Error;
use crate::space::written;
use std::fmt::Display;

const STYLE: &str = include_str!("style.css");

/// Returns a page in one file; no-break spaces keep each unit on the line of its number.
pub(crate) fn page(title: &str, body: &str) -> String {
    let body = [" %", " °", " mm"]
        .iter()
        .fold(body.to_owned(), |body, unit| body.replace(unit, &unit.replace(' ', "\u{a0}")));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{body}</main>\n\
         </body>\n</html>\n",
        text(title)
    )
}

/// Escapes text for HTML: names come from files and may hold anything.
pub(crate) fn text(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut out, character| {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if c.is_control() => out.extend(c.escape_default()),
            c => out.push(c),
        }
        out
    })
}

/// Returns a section under a heading; `content` is HTML.
pub(crate) fn section(heading: &str, content: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{content}</section>\n", text(heading))
}

/// Returns a paragraph; `content` is HTML.
pub(crate) fn paragraph(content: &str) -> String {
    format!("<p>{content}</p>\n")
}

/// Returns a table of HTML cells: text in the first column, figures aligned right in the others.
pub(crate) fn table(head: &[impl Display], rows: &[Vec<String>]) -> String {
    let mut out = String::from("<div class=\"wide\"><table>\n<thead><tr>");
    for cell in head {
        out += &format!("<th scope=\"col\">{cell}</th>");
    }
    out += "</tr></thead>\n<tbody>\n";
    for row in rows {
        out += "<tr>";
        for (column, cell) in row.iter().enumerate() {
            out += &match column {
                0 => format!("<th scope=\"row\">{cell}</th>"),
                _ => format!("<td>{cell}</td>"),
            };
        }
        out += "</tr>\n";
    }
    out + "</tbody>\n</table></div>\n"
}

/// Returns pictures in rows of `columns`; each figure is HTML.
pub(crate) fn side_by_side(columns: usize, figures: &[String]) -> String {
    format!("<div class=\"row\" style=\"--n:{columns}\">\n{}</div>\n", figures.concat())
}

/// Returns a picture with HTML over it and a caption of HTML under it.
///
/// # Errors
/// The picture cannot be encoded.
pub(crate) fn figure(
    picture: &Picture,
    description: &str,
    over: &str,
    caption: &str,
) -> Result<String, Error> {
    let (width, height) = (picture.size.width, picture.size.height);
    Ok(format!(
        "<figure><div class=\"picture\"><img alt=\"{}\" width=\"{width}\" height=\"{height}\" \
         src=\"{}\">{over}</div><figcaption>{caption}</figcaption></figure>\n",
        text(description),
        picture.data_uri()?
    ))
}

/// Formats an error in % of the diagonal, as `sinew eval` prints it.
pub(crate) fn percent(value: f64) -> String {
    format!("{value:.4}")
}

/// Returns a length in millimetres, to stand below the figure of a cell; empty if the unit is not known.
pub(crate) fn below(millimetres: Option<f64>) -> String {
    millimetres.map_or(String::new(), |length| format!("<small>{} mm</small>", written(length)))
}

/// Formats a number with a thin space before each three digits.
pub(crate) fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let first = (digits.len() + 2) % 3 + 1;
    let mut out = digits[..first].to_owned();
    for start in (first..digits.len()).step_by(3) {
        out.push('\u{202f}');
        out += &digits[start..start + 3];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_become_markup() {
        assert_eq!(
            text("<b a=\"1\" b='2'>&\u{7}é"),
            "&lt;b a=&quot;1&quot; b=&#39;2&#39;&gt;&amp;\\u{7}é"
        );
    }

    #[test]
    fn a_unit_stays_with_its_number() {
        let page = page("", &paragraph("0.1 % off, 2 °"));
        assert!(page.contains("<p>0.1\u{a0}% off, 2\u{a0}°</p>"), "{page}");
    }

    #[test]
    fn digits_are_grouped_by_three() {
        for (number, expected) in [(0, "0"), (999, "999"), (1000, "1 000"), (26_756, "26 756")] {
            assert_eq!(grouped(number).replace('\u{202f}', " "), expected);
        }
        assert_eq!(grouped(1_622_480).replace('\u{202f}', " "), "1 622 480");
    }
}
