//! The lines of linuxcncrsh: an exchange with LinuxCNC 2.9.0~pre1 (Debian 12), recorded, and any garbage.

use proptest::prelude::*;
use trunnion_protocol::linuxcncrsh::{
    Item, JointUnit, LONGEST_LINE, Lines, ProgramStatus, Reply, Request, parse_reply, parse_request,
    write_reply, write_request,
};

/// As sent by linuxcncrsh of a five-axis machine; the second and third line repeat requests.
const RECORDED: &str = "HELLO ACK EMCNETSVR 1.1\r\nget joint_pos\r\nset echo off\r\n\
    JOINT_POS 0.000000 -12.500000 0.000000 45.000000 -90.000000 0.000000\r\n\
    JOINT_UNITS MM MM MM DEG DEG MM\r\nPROGRAM_STATUS IDLE\r\nPROGRAM NONE\r\nPROGRAM_LINE 0\r\n\
    GET NONSENSE NAK\r\n\r\nHELLO NAK\r\n";

fn replies(bytes: &[u8]) -> Vec<Reply> {
    let mut lines = Lines::default();
    lines.push(bytes).iter().filter_map(|line| parse_reply(line).expect("a reply")).collect()
}

#[test]
fn the_recorded_exchange_is_read() {
    use JointUnit::{Degree, Mm};
    let expected = [
        Reply::Hello { server: "EMCNETSVR".into(), version: "1.1".into() },
        Reply::JointPos(vec![0.0, -12.5, 0.0, 45.0, -90.0, 0.0]),
        Reply::JointUnits(vec![Mm, Mm, Mm, Degree, Degree, Mm]),
        Reply::ProgramStatus(ProgramStatus::Idle),
        Reply::Program(None),
        Reply::ProgramLine(0),
        Reply::Refused("GET NONSENSE NAK".into()),
        Reply::HelloRefused,
    ];
    assert_eq!(replies(RECORDED.as_bytes()), expected);
    for reply in expected {
        assert_eq!(replies(write_reply(&reply).as_bytes()), [reply]);
    }
}

#[test]
fn requests_are_read_as_written_and_capitals_do_not_matter() {
    let hello = Request::Hello { password: "EMC".into() };
    for request in
        Item::WORDS.map(|(_, item)| Request::Get(item)).into_iter().chain([hello, Request::EchoOff])
    {
        assert_eq!(parse_request(&write_request(&request)), Some(request));
    }
    assert_eq!(parse_request("GET Joint_Pos 0"), Some(Request::Get(Item::JointPos)));
    assert_eq!(parse_request("set machine on"), None);
}

#[test]
fn names_of_programs_keep_their_spaces_and_numbers_must_be_numbers() {
    let program = Reply::Program(Some("/home/cnc/my cycle.ngc".into()));
    assert_eq!(parse_reply("PROGRAM /home/cnc/my cycle.ngc"), Ok(Some(program)));
    assert!(parse_reply("JOINT_POS 1.0 nan").is_err());
    assert!(parse_reply("JOINT_POS 1.0 12,5").is_err());
    assert!(parse_reply("SSH-2.0-OpenSSH_9.2").is_err());
}

proptest! {
    #[test]
    fn any_split_gives_the_same_lines(cut in 0..RECORDED.len()) {
        let (head, tail) = RECORDED.as_bytes().split_at(cut);
        let mut lines = Lines::default();
        let mut split = lines.push(head);
        split.extend(lines.push(tail));
        prop_assert_eq!(split, Lines::default().push(RECORDED.as_bytes()));
    }

    #[test]
    fn no_bytes_panic_and_none_are_lost_without_count(bytes in proptest::collection::vec(any::<u8>(), 0..3 * LONGEST_LINE)) {
        let mut lines = Lines::default();
        let read = lines.push(&bytes);
        let kept: usize = read.iter().map(String::len).sum();
        prop_assert!(kept as u64 + lines.dropped_bytes() <= bytes.len() as u64);
        for line in read {
            prop_assert!(line.len() <= LONGEST_LINE);
            let _answer = (parse_reply(&line), parse_request(&line));
        }
        // What comes next is read again.
        let next = lines.push(b"\nPROGRAM_LINE 7\r\n").pop();
        prop_assert_eq!(next.as_deref(), Some("PROGRAM_LINE 7"));
    }
}
