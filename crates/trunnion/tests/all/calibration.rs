//! What the certificates of the sensors say goes from a setup file into recording, report and certificate; a run after its last day is
//! doubted.

use std::path::{Path, PathBuf};
use trunnion::Filing;
use trunnion::report::{Issuer, Language, check_text, dcc_xml, report_html};
use trunnion::results::{DoubtReason, Report};
use trunnion_cycles::RunKind;
use trunnion_record::RunHeader;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity");
/// 2026-08-01 08:00 UTC.
const MEASURED_NS: i64 = 1_785_571_200_000_000_000;

/// The committed points, imported with these tables in their setup file, on a known day.
fn imported(folder: &Path, calibrations: &str) -> PathBuf {
    let setup = std::fs::read_to_string(Path::new(DATA).join("setup.toml")).unwrap();
    std::fs::write(folder.join("setup.toml"), setup + calibrations).unwrap();
    let (points, undated) = (Path::new(DATA).join("points.csv"), folder.join("undated.mcap"));
    trunnion::tables::import(RunKind::Static, &points, &folder.join("setup.toml"), &undated).unwrap();
    let header = trunnion_record::read_header(&undated).unwrap();
    let dated = folder.join("dated.mcap");
    let run = trunnion::read(&undated, None).unwrap().run;
    let header = RunHeader { name: "dated".into(), wall_start_ns: MEASURED_NS, ..header };
    trunnion_record::write_run(&dated, &header, &run).unwrap();
    dated
}

fn report(recording: &Path) -> Report {
    let run = trunnion::open(recording).unwrap();
    let compared = run.fit(&run.base_model()).unwrap().compare();
    compared.report(&[recording.into()], &Filing::default()).unwrap()
}

fn calibration(valid_until: &str) -> String {
    format!(
        "\n[[calibration]]\nsensor = \"probe-1\"\nserial = \"1702\"\ncertificate = \"K-2025-081\"\nlaboratory = \"Prüfstelle\"\n\
         date = 2025-05-12\nvalid_until = {valid_until}\n\n[[calibration]]\nsensor = \"probe-2\"\nserial = \"1703\"\n"
    )
}

#[test]
fn the_report_says_serial_number_certificate_and_day_of_each_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let report = report(&imported(folder.path(), &calibration("2026-08-01")));
    let [first, second] = &report.identity.runs[0].calibrations[..] else { panic!("two sensors") };
    assert_eq!((first.sensor.as_str(), first.date.as_deref()), ("probe-1", Some("2025-05-12")));
    assert_eq!((second.serial.as_deref(), &second.certificate), (Some("1703"), &None));
    assert!(report.comparison.identification.doubts.is_empty(), "valid on its last day");
    let page = report_html(&report, Language::English);
    let (first_page, others) = page.split_once("Machine and measurement").unwrap();
    assert!(first_page.contains("<dd>probe-1: 1702, K-2025-081, 2025-05-12</dd><dd>probe-2: 1703</dd>"));
    for said in ["<td>Prüfstelle</td><td>2025-05-12</td><td>2026-08-01</td>", "<td>probe-2</td><td>1703</td>"]
    {
        assert!(others.contains(said), "{said}: {others}");
    }
    for (language, head) in [(Language::German, "Kalibrierscheine"), (Language::Japanese, "校正証明書")]
    {
        assert!(report_html(&report, language).contains(head), "{head}");
    }
    let issuer = Issuer { country: Some("DE".into()), ..Issuer::default() };
    let xml = dcc_xml(&report, &issuer).unwrap().replace('\n', "");
    for said in [
        "<dcc:issuer>manufacturer</dcc:issuer><dcc:value>1702</dcc:value>",
        "<dcc:issuer>calibrationLaboratory</dcc:issuer><dcc:value>K-2025-081</dcc:value>",
    ] {
        assert!(xml.contains(said), "{said}: {xml}");
    }
}

#[test]
fn a_run_after_the_last_day_of_a_calibration_is_doubted_on_every_surface() {
    let folder = tempfile::tempdir().unwrap();
    let recording = imported(folder.path(), &calibration("2026-07-31"));
    let said =
        "the calibration of probe-1 was valid until 2026-07-31, and run dated was measured on 2026-08-01.";
    let check = trunnion::open(&recording).unwrap().check();
    assert_eq!(check.doubts[0].reason, DoubtReason::CalibrationOutOfDate);
    assert!(check_text(&check).replace("\n", " ").contains(said), "{}", check_text(&check));
    let page = report_html(&report(&recording), Language::English);
    let first_page = page.split("Machine and measurement").next().unwrap();
    assert!(first_page.contains(&format!("Doubt: {said}")), "{first_page}");
}

#[test]
fn a_recording_without_certificates_says_that_nothing_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let page = report_html(&report(&imported(folder.path(), "")), Language::English);
    assert!(page.contains("<dt>Probe calibration</dt><dd>not recorded</dd>"), "{page}");
}
