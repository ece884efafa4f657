//! What the service writes is for its user and group alone, whoever starts it.

use nix::sys::stat::{Mode, umask};

/// From now on this process, and those that it starts, make files of 0640 and folders of 0750, or stricter where that was asked for.
pub fn keep() {
    let others = Mode::S_IWGRP | Mode::S_IRWXO;
    let before = umask(others);
    umask(before | others);
}
