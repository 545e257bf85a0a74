//! Rust's tokens, as far as paths need them: comments, text and numbers are left out, but for the file in
//! `path = "..."`.

use std::iter::Peekable;
use std::str::Chars;

/// An identifier, `::`, or any other sign alone; after `path =` text, with the quote before it.
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
                    // Text follows, or a character.
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

/// Skips a block comment, in which others may lie.
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

/// Reads text to its end; what a backslash stands for is left out.
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

/// Skips raw text; returns the name where it was a raw identifier.
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
        // A lifetime: its name ends by itself.
        while rest.next_if(|next| next.is_alphanumeric() || *next == '_').is_some() {}
    }
}
