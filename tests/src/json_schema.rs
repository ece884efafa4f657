//! Whether a JSON value is as one of our schemas says. Tests of other crates take this file in by its path.

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

/// What is not as the schema says; empty where all is.
///
/// # Panics
/// When the schema is none.
pub fn differences(value: &Value, schema: &Value) -> Vec<String> {
    let schema = jsonschema::validator_for(schema).unwrap_or_else(|bad| panic!("no schema: {bad}"));
    schema.iter_errors(value).map(|error| format!("{}: {error}", error.instance_path())).collect()
}
