//! How long a call may go on: as long as `--for` says, and no longer than a scheduler lets it.

use std::{
    env,
    process::{Command, Stdio},
    time::{Duration, Instant, SystemTime},
};

/// For the last control step and for saving all cells, before a job's end; but at most a share of
/// what is left of the job, or one of a minute would do nothing.
const MARGIN: Duration = Duration::from_secs(60);
const SHARE: u32 = 10;

/// The time after which a call that may take `asked` from now on is to stop; none if nothing limits it.
/// Slurm may let one wait for its answer.
#[must_use]
pub fn time_limit(asked: Option<Duration>) -> Option<Duration> {
    let begin = Instant::now();
    let left = left_of_job();
    let asked = asked.map(|asked| asked.saturating_sub(begin.elapsed()));
    asked.into_iter().chain(left.map(|left| left - MARGIN.min(left / SHARE))).min()
}

/// How long the Slurm job goes on that this process is part of, if Slurm tells. It does since 23.02,
/// and before that if it's asked.
fn left_of_job() -> Option<Duration> {
    let job = env::var("SLURM_JOB_ID").ok()?;
    if let Ok(end) = env::var("SLURM_JOB_END_TIME") {
        return until(&end, SystemTime::now());
    }
    let mut squeue = Command::new("squeue");
    squeue.args(["--noheader", "--format=%L", "--jobs", &job]).stdin(Stdio::null());
    let said = squeue.stderr(Stdio::null()).output().ok()?;
    // An array's first task has the number of the whole array, all of whose tasks are told.
    span(str::from_utf8(&said.stdout).ok()?.lines().next()?)
}

/// Until a number of seconds since 1970; none is left of a job that is over.
fn until(end: &str, now: SystemTime) -> Option<Duration> {
    let end = Duration::from_secs(end.trim().parse().ok()?);
    let end = SystemTime::UNIX_EPOCH.checked_add(end)?;
    Some(end.duration_since(now).unwrap_or_default())
}

/// `DAYS-HOURS:MINUTES:SECONDS`, from the left as far as it's zero left out; none for words.
fn span(text: &str) -> Option<Duration> {
    let text = text.trim();
    let (days, rest) = text.split_once('-').unwrap_or(("0", text));
    let parts: Vec<u32> = rest.split(':').map(|part| part.parse().ok()).collect::<Option<_>>()?;
    let [hours, minutes, seconds] = match parts[..] {
        [minutes, seconds] => [0, minutes, seconds],
        [hours, minutes, seconds] => [hours, minutes, seconds],
        _ => return None,
    };
    let hours = 24 * u64::from(days.parse::<u32>().ok()?) + u64::from(hours);
    let seconds = 60 * (60 * hours + u64::from(minutes)) + u64::from(seconds);
    Some(Duration::from_secs(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jobs_end_is_read_as_slurm_tells_it() {
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000);
        let until = |end| until(end, now).map(|it| it.as_secs());
        assert_eq!(until("1003600\n"), Some(3600));
        assert_eq!(until("999999"), Some(0));
        assert_eq!([until("Unknown"), until("18446744073709551615")], [None, None]);

        let span = |text| span(text).map(|it| it.as_secs());
        assert_eq!([span("0:42\n"), span("59:01")], [Some(42), Some(3541)]);
        assert_eq!(span("2:00:00"), Some(7200));
        assert_eq!(span("1-00:00:09"), Some(86_409));
        for none in ["UNLIMITED", "INVALID", "", "42", "1:2:3:4", "-1:00"] {
            assert_eq!(span(none), None, "{none}");
        }
    }
}
