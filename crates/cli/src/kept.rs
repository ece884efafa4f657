//! Where this program keeps what it worked out, for its next start: a folder of its user, in which everything may be deleted.

use std::ffi::OsString;
use std::path::PathBuf;

/// Names the folder; empty: nothing is kept.
const OWN: &str = "TRUNNION_CACHE_DIR";

/// The folder; `None` where nothing is to be kept, or nobody says where.
pub fn folder() -> Option<PathBuf> {
    of(|name| std::env::var_os(name))
}

/// As systemd gives it (`CacheDirectory=`), else in the cache of the user [XDG Base Directory Specification].
fn of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(own) = variable(OWN) {
        return Some(PathBuf::from(own)).filter(|own| !own.as_os_str().is_empty());
    }
    let absolute = |name| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    absolute("CACHE_DIRECTORY").or_else(|| {
        let of_user = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")));
        of_user.map(|path| path.join("trunnion"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folder_is_the_one_that_is_named_else_that_of_the_service_else_that_of_the_user() {
        let check = |set: &[(&str, &str)], expected: Option<&str>| {
            let variable =
                |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into());
            assert_eq!(of(variable), expected.map(PathBuf::from), "{set:?}");
        };
        let (home, cache) = (("HOME", "/home/ada"), ("XDG_CACHE_HOME", "/var/tmp/ada"));
        check(&[], None);
        check(&[home], Some("/home/ada/.cache/trunnion"));
        check(&[home, cache], Some("/var/tmp/ada/trunnion"));
        check(&[home, ("XDG_CACHE_HOME", "not/absolute")], Some("/home/ada/.cache/trunnion"));
        check(&[home, ("CACHE_DIRECTORY", "/var/cache/trunnion")], Some("/var/cache/trunnion"));
        check(&[home, (OWN, "here")], Some("here"));
        check(&[home, (OWN, "")], None);
    }
}
