//! The grid of settings.

use std::str::FromStr;
use thiserror::Error;

/// A key and the values it takes, written `key=value,value,…`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variation {
    /// Dotted key.
    pub key: String,
    /// Its values, as they would be written in a case file.
    pub values: Vec<String>,
}

/// A variation that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{0}`: a variation is written key=value,value")]
pub struct VariationError(String);

impl FromStr for Variation {
    type Err = VariationError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let failed = || VariationError(text.to_owned());
        let (key, list) = text.split_once('=').ok_or_else(failed)?;
        let values: Vec<String> = split(list).into_iter().map(|v| v.trim().to_owned()).collect();
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(failed());
        }
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

/// The parts of `list` between commas that are neither in brackets nor in quotes.
fn split(list: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let (mut depth, mut quoted) = (0i32, false);
    for c in list.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts
}

/// Every combination of the values, as overrides `key=value`; the last variation changes fastest.
#[must_use]
pub fn grid(variations: &[Variation]) -> Vec<Vec<String>> {
    variations.iter().fold(vec![Vec::new()], |combinations, variation| {
        combinations
            .into_iter()
            .flat_map(|settings| {
                variation.values.iter().map(move |value| {
                    let mut settings = settings.clone();
                    settings.push(format!("{}={value}", variation.key));
                    settings
                })
            })
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_told_apart_by_commas_outside_of_brackets_and_quotes() {
        let found: Variation = "a.b = 1, 2.5".parse().unwrap();
        assert_eq!(found, Variation { key: "a.b".into(), values: vec!["1".into(), "2.5".into()] });
        let found: Variation = "a=[1,2],[3]".parse().unwrap();
        assert_eq!(found.values, ["[1,2]", "[3]"]);
        let found: Variation = "a=\"x,y\",{b = 1, c = 2}".parse().unwrap();
        assert_eq!(found.values, ["\"x,y\"", "{b = 1, c = 2}"]);
        for bad in ["a", "=1", "a=", "a=1,,2"] {
            assert!(bad.parse::<Variation>().is_err(), "{bad}");
        }
    }

    #[test]
    fn all_combinations() {
        let variations: Vec<Variation> =
            ["a=1,2", "b=x,y,z"].iter().map(|text| text.parse().unwrap()).collect();
        let found = grid(&variations);
        assert_eq!(found.len(), 6);
        assert_eq!(found[0], ["a=1", "b=x"]);
        assert_eq!(found[5], ["a=2", "b=z"]);
        assert_eq!(grid(&[]), [Vec::<String>::new()]);
    }
}
