//! Splits Rust source into the tokens that paths need. Comments, strings and numbers are dropped,
//! except the file in `path = "..."`.

use std::iter::Peekable;
use std::str::Chars;

/// Returns identifiers, `::`, and other characters one at a time. The string after `path =` is
/// kept, with its opening quote.
pub(super) fn tokens(source: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut rest = source.chars().peekable();
    while let Some(sign) = rest.next() {
        match sign {
            '/' if rest.peek() == Some(&'/') => {
                while rest.next_if(|next| *next != '\n').is_some() {}
            }
            '/' if rest.peek() == Some(&'*') => skip_comment(&mut rest),
            '"' => {
                let text = text(&mut rest);
                if out.ends_with(&["path".to_owned(), "=".to_owned()]) {
                    out.push(format!("\"{text}"));
                }
            }
            '\'' => skip_character_or_lifetime(&mut rest),
            sign if sign.is_alphabetic() || sign == '_' => {
                let word = word(sign, &mut rest);
                let is_prefix = ["r", "b", "br", "c", "cr"].contains(&word.as_str());
                match rest.peek() {
                    Some('"' | '#') if is_prefix && word.contains('r') => {
                        if let Some(name) = skip_raw_text(&mut rest) {
                            out.push(name);
                        }
                    }
                    // A string or a character follows.
                    Some('"' | '\'') if is_prefix => {}
                    _ => out.push(word),
                }
            }
            sign if sign.is_numeric() => {
                word(sign, &mut rest);
            }
            ':' if rest.next_if_eq(&':').is_some() => out.push("::".to_owned()),
            sign if sign.is_whitespace() => {}
            sign => out.push(sign.to_string()),
        }
    }
    out
}

fn word(first: char, rest: &mut Peekable<Chars<'_>>) -> String {
    let mut out = String::from(first);
    while let Some(next) = rest.next_if(|next| next.is_alphanumeric() || *next == '_') {
        out.push(next);
    }
    out
}

/// Skips a block comment, which may contain nested comments.
fn skip_comment(rest: &mut Peekable<Chars<'_>>) {
    let mut depth = 0;
    let mut last = '/';
    for next in rest.by_ref() {
        match (last, next) {
            ('/', '*') => depth += 1,
            ('*', '/') => depth -= 1,
            _ => {
                last = next;
                continue;
            }
        }
        if depth == 0 {
            return;
        }
        last = ' ';
    }
}

/// Reads a string to its end; drops characters after a backslash.
fn text(rest: &mut Peekable<Chars<'_>>) -> String {
    let mut out = String::new();
    while let Some(next) = rest.next() {
        match next {
            '\\' => {
                rest.next();
            }
            '"' => break,
            next => out.push(next),
        }
    }
    out
}

/// Skips a raw string; returns the name if the token is a raw identifier.
fn skip_raw_text(rest: &mut Peekable<Chars<'_>>) -> Option<String> {
    let mut signs = 0;
    while rest.next_if_eq(&'#').is_some() {
        signs += 1;
    }
    if rest.next_if_eq(&'"').is_none() {
        return rest.next().map(|first| word(first, rest));
    }
    while let Some(next) = rest.next() {
        if next == '"' {
            let mut found = 0;
            while found < signs && rest.next_if_eq(&'#').is_some() {
                found += 1;
            }
            if found == signs {
                return None;
            }
        }
    }
    None
}

fn skip_character_or_lifetime(rest: &mut Peekable<Chars<'_>>) {
    let first = rest.next();
    if first == Some('\\') {
        rest.next();
        while rest.next().is_some_and(|next| next != '\'') {}
    } else if rest.next_if_eq(&'\'').is_none() {
        // A lifetime: ends with its name.
        while rest.next_if(|next| next.is_alphanumeric() || *next == '_').is_some() {}
    }
}
