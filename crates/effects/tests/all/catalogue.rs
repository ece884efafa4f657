//! Walks the registry and the catalogue directory: what every effect must keep.

use crate::scenes::{machines, rich_states, scene};
use std::collections::BTreeSet;
use std::path::Path;
use trunnion_effects::catalogue::{BASE, LOCATION_ERRORS, REGISTRY, effect as effect_of};
use trunnion_effects::{Checked, Instance, Role};
use trunnion_machine::shipped;

const DIRECTORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/catalogue");

#[test]
fn every_file_of_the_directory_is_registered_under_its_name() {
    let files: BTreeSet<String> = std::fs::read_dir(DIRECTORY)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().replace('_', "-"))
        .collect();
    let registered: Vec<String> = REGISTRY.iter().map(|effect| effect.phenomenon.into()).collect();
    let registry: BTreeSet<String> = registered.iter().cloned().collect();
    let missing: Vec<&String> = files.difference(&registry).collect();
    assert!(
        missing.is_empty(),
        "{missing:?}: no line in REGISTRY, or phenomenon is not the name of the file"
    );
    assert_eq!(files, registry);
    assert_eq!(files.len(), registered.len(), "an effect is registered twice");
}

#[test]
fn every_effect_says_what_it_is() {
    for effect in REGISTRY {
        let about = &effect.about;
        let texts = [
            about.title,
            about.source,
            about.equation,
            about.symbols,
            about.validity,
            about.typical,
            about.explanation,
            about.cause,
            about.seen_by,
        ];
        assert!(texts.iter().all(|text| text.len() > 2), "{}", effect.phenomenon);
        assert_eq!(BASE.contains(&effect.phenomenon), about.needs.is_empty(), "{}", effect.phenomenon);
        assert!(!about.helps.is_empty(), "{}", effect.phenomenon);
        let file = Path::new(DIRECTORY).join(format!("{}.rs", effect.phenomenon.replace('-', "_")));
        let code = std::fs::read_to_string(file).unwrap();
        let header: String = code.lines().take_while(|line| line.starts_with("//!")).collect();
        assert!(header.contains("Limits:") || header.contains("limits"), "{}", effect.phenomenon);
        assert!(header.contains('['), "{} names no source", effect.phenomenon);
    }
}

#[test]
fn the_base_model_is_location_errors_and_setting() {
    let roles = BASE.map(|id| effect_of(id).unwrap().role);
    assert_eq!((BASE[0], roles), (LOCATION_ERRORS, [Role::Location, Role::Setting]));
    let first: Vec<&str> = REGISTRY.iter().take(2).map(|effect| effect.phenomenon).collect();
    assert_eq!(first, BASE, "{first:?}");
    for effect in REGISTRY {
        let price_ln = effect.role.price_ln();
        // Beyond odds of a million no data would ever name it.
        assert!((0.0..14.0).contains(&price_ln), "{}: {price_ln}", effect.phenomenon);
    }
}

#[test]
fn every_effect_has_a_golden_case_and_reads_what_it_says() {
    let bc = Instance::all(&shipped::machine("table-bc").unwrap());
    let mut wrong = Vec::new();
    for effect in REGISTRY {
        let (id, golden) = (effect.phenomenon, &effect.golden);
        let own: Vec<String> = bc
            .iter()
            .filter(|instance| effect_of(&instance.id()).unwrap().phenomenon == id)
            .map(Instance::id)
            .collect();
        if let Some(foreign) = [golden.id, effect.example.id].iter().find(|one| own.iter().all(|o| o != *one))
        {
            wrong.push(format!("{id}: \"{foreign}\" is none of its ids on machine table-bc, {own:?}"));
            continue;
        }
        if golden.source.len() < 3 || golden.derivation.len() < 20 {
            wrong.push(format!("{id}: no source or no derivation"));
        }
        if let Some(flaw) = golden.flaw() {
            wrong.push(format!("{id}: {flaw}"));
            continue;
        }
        let checked = golden.check();
        let largest_um = checked.iter().map(|one| one.expected_um.amax()).fold(0.0, f64::max);
        if largest_um == 0.0 {
            wrong.push(format!("{id}: no moment expects a reading other than zero"));
            continue;
        }
        // A tenth: a case that looser numbers would pass proves no sign and no unit.
        if !(1e-9..=0.1 * largest_um).contains(&golden.within_um) {
            wrong.push(format!("{id}: {largest_um} µm within {} µm is no proof", golden.within_um));
        }
        for (k, Checked { expected_um, found_um }) in checked.iter().enumerate() {
            if (found_um - expected_um).amax() > golden.within_um {
                let [expected_um, found_um] = [expected_um, found_um].map(|v| [v.x, v.y, v.z]);
                wrong.push(format!("{id}, reading {k}: {expected_um:?} µm expected, {found_um:?} found"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn ids_that_model_files_hold_stay_in_the_catalogue() {
    // On a machine with tilting B and turning C. A new effect needs no entry here; docs/design/catalogue.md lists all.
    let (rotary, linear, all) = (["B", "C"], ["X", "Y", "Z"], ["X", "Y", "Z", "B", "C"]);
    let of = |phenomena: &[&str], axes: &[&str]| -> Vec<String> {
        phenomena.iter().flat_map(|p| axes.iter().map(move |axis| format!("{p}:{axis}"))).collect()
    };
    let mut expected: BTreeSet<String> = [
        "location-errors",
        "ball-setting",
        "gravity-sag:B",
        "unbalance:C",
        "thermal-drift",
        "thermal-expansion",
        "spindle-growth",
        "stacked-tilt:C",
        "squareness:YX",
        "squareness:ZX",
        "squareness:ZY",
        "sync-delay",
        "setup-slip",
        "probe-crosstalk",
        "probe-gain",
        "probe-nonlinearity",
        "nest-rotation",
        "ball-form",
        "artefact-form",
        "vibration",
    ]
    .map(String::from)
    .into();
    expected.extend(of(&["backlash", "reversal-spike", "servo-lag", "inertial-deflection"], &all));
    expected.extend(of(&["direction-shift", "encoder-eccentricity", "drive-pitch", "clamp-shift"], &rotary));
    expected.extend(of(&["radial-error-motion", "axial-error-motion", "tilt-error-motion"], &rotary));
    expected.extend(of(
        &["linear-scale", "straightness", "angular-motion", "component-errors", "ballscrew-pitch"],
        &linear,
    ));
    let machine = shipped::machine("table-bc").unwrap();
    let found: BTreeSet<String> = Instance::all(&machine).iter().map(Instance::id).collect();
    let gone: Vec<&String> = expected.difference(&found).collect();
    assert!(gone.is_empty(), "model files with {gone:?} would not be read any more");
    let machine = shipped::machine("table-ac").unwrap();
    let found: BTreeSet<String> = Instance::all(&machine).iter().map(Instance::id).collect();
    assert!(found.contains("gravity-sag:A") && !found.contains("gravity-sag:B"), "{found:?}");
}

#[test]
fn every_example_is_an_effect_of_the_machine_and_can_be_drawn() {
    let pictures = trunnion_effects::catalogue_pictures();
    assert_eq!(pictures.len(), REGISTRY.len());
    let machine = shipped::machine("table-bc").unwrap();
    let scene = scene(&machine, &rich_states(&machine));
    for (effect, picture) in REGISTRY.iter().zip(&pictures) {
        assert_eq!(effect.example.id.split(':').next(), Some(effect.phenomenon));
        let svg = &picture.svg;
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", effect.phenomenon);
        // A flat line of nothing would be no signature: some path leaves its first height.
        assert!(svg.contains("<path") && svg.len() > 1500, "{}", effect.phenomenon);
        let instance = Instance::find(effect.example.id, &machine).unwrap();
        let names: Vec<String> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
        for (name, value) in effect.example.values {
            assert!(
                names.iter().any(|known| known == name),
                "{}: {name} is none of {names:?}",
                effect.phenomenon
            );
            assert!(*value != 0.0, "{}: {name}", effect.phenomenon);
        }
    }
}

#[test]
fn ids_and_parameter_names_are_unique_and_ids_lead_back() {
    for machine in machines() {
        let scene = scene(&machine, &rich_states(&machine));
        let mut ids = BTreeSet::new();
        for instance in Instance::all(&machine) {
            assert!(ids.insert(instance.id()), "{} twice", instance.id());
            assert_eq!(Instance::find(&instance.id(), &machine).unwrap().id(), instance.id());
            let names: Vec<_> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
            let unique: BTreeSet<_> = names.iter().collect();
            assert_eq!(unique.len(), names.len(), "{} {names:?}", instance.id());
        }
    }
    let unknown = Instance::find("gravity-sga", &machines()[0]).unwrap_err().to_string();
    assert!(unknown.contains("gravity-sag:B"), "{unknown}");
}

#[test]
fn the_catalogue_document_and_its_pictures_are_current() {
    const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/design");
    let found = |file: String| std::fs::read_to_string(Path::new(DOCS).join(file)).unwrap_or_default();
    let again = "is not current: cargo run -p trunnion-effects --example catalogue";
    assert!(
        found("catalogue.md".into()) == trunnion_effects::catalogue_markdown(),
        "docs/design/catalogue.md {again}"
    );
    let pictures = trunnion_effects::catalogue_pictures();
    for picture in &pictures {
        let file = format!("catalogue/{}", picture.file);
        assert!(found(file.clone()) == picture.svg, "docs/design/{file} {again}");
    }
    let files = std::fs::read_dir(Path::new(DOCS).join("catalogue")).unwrap().count();
    assert_eq!(files, pictures.len(), "docs/design/catalogue holds pictures of no effect");
}
