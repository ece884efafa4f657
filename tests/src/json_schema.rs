//! Whether a JSON value is as one of our schemas says: the words of JSON Schema that `docs/schemas` uses, and no other. Tests of other
//! crates take this file in by its path.

use serde_json::Value;
use std::path::Path;

/// Topics whose schema has another name, for other answers have it too.
const OTHER_NAMES: [(&str, &str); 3] =
    [("model", "model-changed"), ("quality", "time-quality"), ("removed", "samples-removed")];

/// The schema that the documents name for a topic of the service.
///
/// # Panics
/// When there is none.
pub fn schema_of_topic(topic: &str) -> Value {
    let name = OTHER_NAMES.iter().find(|(of, _)| *of == topic).map_or(topic, |(_, name)| name);
    let folders =
        ["../docs/schemas", "../../docs/schemas"].map(|up| Path::new(env!("CARGO_MANIFEST_DIR")).join(up));
    let file = format!("{name}.schema.json");
    let text = folders.iter().find_map(|folder| std::fs::read_to_string(folder.join(&file)).ok());
    serde_json::from_str(&text.unwrap_or_else(|| panic!("no {file}")))
        .unwrap_or_else(|bad| panic!("{file}: {bad}"))
}

/// Words that ask nothing of a value.
const OF_NO_VALUE: [&str; 7] =
    ["$schema", "$defs", "title", "description", "format", "default", "additionalProperties"];

/// What is not as the schema says; empty where all is.
///
/// # Panics
/// Where the schema has a word that is not known here: a value would pass that nobody checked.
pub fn differences(value: &Value, schema: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(value, schema, schema, "", &mut found);
    found
}

fn check(value: &Value, schema: &Value, whole: &Value, at: &str, found: &mut Vec<String>) {
    let Value::Object(words) = schema else {
        assert_eq!(schema, &Value::Bool(true), "{at}: no value is allowed");
        return;
    };
    for (word, asked) in words {
        let list = || asked.as_array().into_iter().flatten();
        let mut refuse = |what: String| found.push(format!("{at}: {what}"));
        match word.as_str() {
            "$ref" => {
                let pointer = asked.as_str().and_then(|text| text.strip_prefix('#')).unwrap_or_default();
                let named = whole.pointer(pointer).unwrap_or_else(|| panic!("no {asked} in the schema"));
                check(value, named, whole, at, found);
            }
            "type" => {
                let is = |name: &Value| is_of(value, name.as_str().unwrap_or_default());
                if !is(asked) && !list().any(is) {
                    refuse(format!("{value} is no {asked}"));
                }
            }
            "const" if asked != value => refuse(format!("{value} is not {asked}")),
            "enum" if !list().any(|one| one == value) => refuse(format!("{value} is none of {asked}")),
            "minimum" if value.as_f64() < asked.as_f64() => refuse(format!("{value} is less than {asked}")),
            "maximum" if value.as_f64() > asked.as_f64() => refuse(format!("{value} is more than {asked}")),
            "const" | "enum" | "minimum" | "maximum" => {}
            "required" => list()
                .filter(|key| value.is_object() && value.get(key.as_str().unwrap_or_default()).is_none())
                .for_each(|key| refuse(format!("{key} is missing"))),
            "properties" => {
                for (key, of_key) in asked.as_object().into_iter().flatten() {
                    if let Some(value) = value.get(key) {
                        check(value, of_key, whole, &format!("{at}/{key}"), found);
                    }
                }
            }
            "items" => {
                for (k, value) in value.as_array().into_iter().flatten().enumerate() {
                    check(value, asked, whole, &format!("{at}/{k}"), found);
                }
            }
            "minItems" | "maxItems" => {
                let (length, limit) = (value.as_array().map(|items| items.len() as u64), asked.as_u64());
                if length.is_some() && if word == "minItems" { length < limit } else { length > limit } {
                    refuse(format!("{value} has not {word} {asked}"));
                }
            }
            "anyOf" | "oneOf" => {
                let of = |one: &Value| {
                    let mut found = Vec::new();
                    check(value, one, whole, at, &mut found);
                    found
                };
                let tried: Vec<Vec<String>> = list().map(of).collect();
                if !tried.iter().any(Vec::is_empty) {
                    refuse(format!("none of {word}: {tried:?}"));
                }
            }
            other => assert!(OF_NO_VALUE.contains(&other), "{at}: {other} of the schema is not checked here"),
        }
    }
    check_others(value, words, whole, at, found);
}

/// Keys that `properties` does not name.
fn check_others(
    value: &Value,
    words: &serde_json::Map<String, Value>,
    whole: &Value,
    at: &str,
    found: &mut Vec<String>,
) {
    let Some(asked) = words.get("additionalProperties") else { return };
    let named = |key: &str| words.get("properties").is_some_and(|properties| properties.get(key).is_some());
    for (key, value) in value.as_object().into_iter().flatten().filter(|(key, _)| !named(key)) {
        match asked {
            Value::Bool(false) => found.push(format!("{at}: {key} is not allowed")),
            asked => check(value, asked, whole, &format!("{at}/{key}"), found),
        }
    }
}

fn is_of(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        _ => false,
    }
}
