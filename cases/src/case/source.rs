//! Reading a case file: TOML with overrides, and where in it each key stands.

use super::{CaseKeys, Problem};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

/// The text of a case with the `--set` overrides, and the place of every key.
#[derive(Debug)]
pub(super) struct Source {
    label: String,
    text: String,
    overrides: Vec<String>,
    /// Dotted key and span of its value. Spans past the end of the text belong to overrides.
    places: Vec<(String, Range<usize>)>,
}

impl Source {
    /// Reads the keys of the case `text`, called `label` in messages, with each of `overrides`
    /// (`dotted.key=value`) replacing or adding a key.
    ///
    /// # Errors
    /// The first syntax error, unknown or missing key, or value of a wrong type.
    pub(super) fn read(
        label: &str,
        text: &str,
        overrides: &[String],
    ) -> Result<(CaseKeys, Self), Problem> {
        let mut source = Self {
            label: label.to_owned(),
            text: text.to_owned(),
            overrides: overrides.to_vec(),
            places: Vec::new(),
        };
        let mut table = DeTable::parse(text).map_err(|error| source.explain(&error))?;
        for (index, assignment) in overrides.iter().enumerate() {
            source.set(table.get_mut(), index, assignment)?;
        }
        let mut places = Vec::new();
        collect_places(table.get_ref(), "", &mut places);
        source.places = places;
        let keys = CaseKeys::deserialize(Deserializer::from(table))
            .map_err(|error| source.explain(&error))?;
        Ok((keys, source))
    }

    /// A problem with the value of `key`, located as well as can be.
    #[must_use]
    pub(super) fn problem(&self, key: &str, message: String) -> Problem {
        // A key that is absent has the place of the table it should stand in.
        let mut path = key;
        loop {
            if let Some((_, span)) = self.places.iter().find(|(place, _)| place == path) {
                return Problem { place: self.place(span.start), key: key.to_owned(), message };
            }
            match path.rsplit_once('.') {
                Some((parent, _)) => path = parent,
                None => break,
            }
        }
        Problem { place: self.label.clone(), key: key.to_owned(), message }
    }

    /// `label:line`, or the override that an offset past the text stands for.
    fn place(&self, offset: usize) -> String {
        match offset.checked_sub(self.text.len() + 1).and_then(|index| self.overrides.get(index)) {
            Some(assignment) => format!("--set {assignment}"),
            None => {
                let before = &self.text.as_bytes()[..offset.min(self.text.len())];
                let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
                format!("{}:{line}", self.label)
            }
        }
    }

    /// A TOML error as one line that names the key where there is one.
    fn explain(&self, error: &Error) -> Problem {
        let message =
            error.message().replace('\n', " ").replace("expected f64", "expected a number");
        let Some(span) = error.span() else {
            return Problem { place: self.label.clone(), key: String::new(), message };
        };
        // The innermost key whose value covers the error.
        let key = self
            .places
            .iter()
            .filter(|(_, place)| place.start <= span.start && span.end <= place.end)
            .min_by_key(|(key, place)| (place.len(), std::cmp::Reverse(key.len())))
            .map_or(String::new(), |(key, _)| key.clone());
        Problem { place: self.place(span.start), key, message }
    }

    /// Applies one override. Its spans all become the offset that stands for it.
    fn set<'a>(
        &self,
        root: &mut DeTable<'a>,
        index: usize,
        assignment: &'a str,
    ) -> Result<(), Problem> {
        let fail = |message: String| Problem {
            place: format!("--set {assignment}"),
            key: String::new(),
            message,
        };
        let offset = self.text.len() + 1 + index;
        let Some((path, text)) = assignment.split_once('=') else {
            return Err(fail("an override is written key=value".to_owned()));
        };
        let (path, text) = (path.trim(), text.trim());
        let value = DeValue::parse(text)
            .map_err(|error| fail(format!("`{text}` is no TOML value: {}", error.message())))?;
        let value = respanned(value.into_inner(), offset);
        let (parents, last) = match path.rsplit_once('.') {
            Some((parents, last)) => (Some(parents), last),
            None => (None, path),
        };
        let mut table = root;
        for segment in parents.into_iter().flat_map(|parents| parents.split('.')) {
            table = match descend(table, segment, offset) {
                Ok(next) => next,
                Err(reason) => return Err(Problem { key: path.to_owned(), ..fail(reason) }),
            };
        }
        // Reinsert, so that the key's own span is the override's too.
        table.remove(last);
        table.insert(Spanned::new(offset..offset, last.into()), value);
        Ok(())
    }
}

/// The table that `segment` names in `table`, made if absent. An entry of a list of tables is
/// written `name[0]`; the index may be left out where there is one entry only.
fn descend<'t, 'a>(
    table: &'t mut DeTable<'a>,
    segment: &'a str,
    offset: usize,
) -> Result<&'t mut DeTable<'a>, String> {
    let (name, index) = match segment.split_once('[') {
        Some((name, index)) => {
            let index = index.trim_end_matches(']').parse::<usize>();
            (name, Some(index.map_err(|_| format!("{segment}: the index is no number"))?))
        }
        None => (segment, None),
    };
    if !table.contains_key(name) {
        let empty = DeValue::Table(DeTable::new());
        table
            .insert(Spanned::new(offset..offset, name.into()), Spanned::new(offset..offset, empty));
    }
    let Some(entry) = table.get_mut(name) else { return Err(format!("{name}: no such key")) };
    match (entry.get_mut(), index) {
        (DeValue::Table(inner), None) => Ok(inner),
        (DeValue::Array(list), index) => {
            let count = list.len();
            let index = match index {
                Some(index) => index,
                None if count == 1 => 0,
                None => return Err(format!("there are {count} {name}: write {name}[0]")),
            };
            match list.get_mut(index).map(Spanned::get_mut) {
                Some(DeValue::Table(inner)) => Ok(inner),
                _ => Err(format!("{name}[{index}]: there are {count}, counted from 0")),
            }
        }
        _ => Err(format!("{segment} is no table")),
    }
}

/// The same value with every span moved to `offset`.
fn respanned(value: DeValue<'_>, offset: usize) -> Spanned<DeValue<'_>> {
    let value = match value {
        DeValue::Array(list) => DeValue::Array(
            list.into_iter().map(|item| respanned(item.into_inner(), offset)).collect(),
        ),
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, item)| {
                    let key = Spanned::new(offset..offset, key.into_inner());
                    (key, respanned(item.into_inner(), offset))
                })
                .collect(),
        ),
        other => other,
    };
    Spanned::new(offset..offset, value)
}

/// Lists `table.list[0].key` with the span of its value for every key below `prefix`.
fn collect_places(table: &DeTable<'_>, prefix: &str, places: &mut Vec<(String, Range<usize>)>) {
    for (key, value) in table {
        let path = match prefix {
            "" => key.get_ref().to_string(),
            _ => format!("{prefix}.{}", key.get_ref()),
        };
        collect_value(value, path, places);
    }
}

fn collect_value(
    value: &Spanned<DeValue<'_>>,
    path: String,
    places: &mut Vec<(String, Range<usize>)>,
) {
    match value.get_ref() {
        DeValue::Table(inner) => collect_places(inner, &path, places),
        DeValue::Array(list) => {
            for (index, item) in list.iter().enumerate() {
                collect_value(item, format!("{path}[{index}]"), places);
            }
        }
        _ => {}
    }
    places.push((path, value.span()));
}
