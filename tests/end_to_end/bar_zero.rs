//! A calibrated length of a bar, and a configuration that does not say from where the bar counts.

use crate::bad_input::check_refused;
use crate::program::{answer, written};

#[test]
fn a_calibrated_length_asks_what_the_bar_shows_at_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| written(folder.path(), name, text);
    let calibrated = include_str!("../../config/cycles/s4-c.toml");
    let cycle = write("s4-c.toml", calibrated);
    let config = |bar: &str| {
        format!(
            "format = \"trunnion-config/1\"\nname = \"m\"\ncycle = \"s4-c.toml\"\nrecordings = \"runs\"\n[[device]]\nname = \"bus\"\n{bar}\n"
        )
    };
    let bars = [
        (
            "bus.node-5",
            "driver = \"canopen-slcan\"\nport = \"none-a\"\nbitrate = 1000000\nnodes = [{ id = 5, role = \"bar\"@ }]",
            ", zero_mm = 10.0",
        ),
        (
            "bus.node-5",
            "driver = \"canopen-socketcan\"\ninterface = \"none-b\"\nnodes = [{ id = 5, role = \"bar\"@ }]",
            ", zero_mm = 0.0",
        ),
        (
            "bus.head-1",
            "driver = \"keyence-dl-rs1a\"\nport = \"none-c\"\nheads = [{ head = 1, role = \"bar\"@ }]",
            ", zero_mm = -2.5",
        ),
        ("bus", "driver = \"optoncdt\"\nport = \"none-d\"\nrole = \"bar\"\nrange_mm = 10@", "\nzero_mm = 5"),
        (
            "bus",
            "driver = \"ascii\"\nport = \"none-e\"\nrole = \"bar\"\npreset = \"mahr-c1202\"@",
            "\nzero_mm = 0",
        ),
    ];
    for (channel, bar, zero) in bars {
        let file = write("trunnion.toml", &config(&bar.replace('@', "")));
        let expected = [
            "s4-c",
            "setup C-X(-Z): calibrated = true",
            &format!("what {channel} shows"),
            "trunnion.toml",
            "zero_mm",
        ];
        check_refused(&["check-config", &file], &expected);
        check_refused(&["record", &cycle, "--config", &file], &expected);
        let check = |text: &str| {
            let output = answer(&["check-config", &write("trunnion.toml", text)]);
            (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
        };
        let (code, said) = check(&config(&bar.replace('@', zero)));
        assert_eq!(code, Some(0), "{channel}: {said}");
        // A cycle that measures changes needs none.
        write("s4-c.toml", &calibrated.replace("calibrated = true\n", ""));
        let (code, said) = check(&config(&bar.replace('@', "")));
        assert_eq!(code, Some(0), "{channel}: {said}");
        write("s4-c.toml", calibrated);
        // What is no bar has no zero.
        let probe = bar.replace("\"bar\"", "\"probe-1\"").replace('@', zero);
        check_refused(&["check-config", &write("trunnion.toml", &config(&probe))], &["zero_mm"]);
    }
}
