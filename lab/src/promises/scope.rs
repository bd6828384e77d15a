//! Share of the bus that a download of the virtual scope takes, beside everything else that a drive sends
//! while its motor runs.

use super::Context;
use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::master::{Download, Request};
use narx_core::motor::Board;
use narx_core::motor::signal::Signal;
use narx_core::scope::State;
use narx_report::figures::{Figure, Part};
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};

/// Four signals at every tick: the whole memory of 4096 words.
const SIGNALS: [Signal; 4] = [Signal::SetPoint, Signal::SpeedHall, Signal::Power, Signal::Angle];
const SAMPLES: i32 = 1024;
/// Words of the record in one frame.
const WORDS: u32 = SIGNALS.len() as u32 * SAMPLES as u32;
/// Longest wait for an answer, s.
const PATIENCE: f64 = 10.0;

/// Makes and downloads a record.
pub(super) fn part(context: &Context<'_>) -> Part {
    match measure(context.board) {
        Ok(figures) => Part::new(figures, Vec::new()),
        Err(reason) => Part::new(
            vec![Figure::new("download of a scope record", f64::NAN, "s").at_least(0.0)],
            vec![reason],
        ),
    }
}

fn measure(board: Board) -> Result<Vec<Figure>, String> {
    let motor = preset("ec45-flat-50w-18v").ok_or("no such motor")?;
    let config = SessionConfig {
        rated_current: motor.data.rated_current,
        board,
        trace: false,
        ..SessionConfig::new(motor.motor, 18.0, Mode::Hall)
    };
    let mut session = Session::new(&config).map_err(|error| error.to_string())?.without_recording();
    session.start(2000);
    session.run(3.0);
    let bits = SIGNALS.iter().map(|signal| 1 << *signal as i32).sum();
    for (number, raw) in [
        (number::SCOPE_CHANNELS, bits),
        (number::SCOPE_SAMPLES, SAMPLES),
        (number::SCOPE_PRESCALER, 1),
        (number::SCOPE_TRIGGER_PHASE, 0),
    ] {
        ask(&mut session, Request::Write { number, raw })?;
    }
    // The first request arms the scope, the second triggers it.
    ask(&mut session, Request::TriggerScope)?;
    ask(&mut session, Request::TriggerScope)?;
    let done = |session: &mut Session| {
        let state = session.bench().node().read_parameter(number::SCOPE_STATE);
        (state == Some(State::Done as i32)).then_some(())
    };
    until(&mut session, done).ok_or("the scope does not end its record")?;
    let idle = load(&mut session, |session| {
        session.run(1.0);
        Ok(())
    })?;
    let begun = session.bench().time();
    let busy = load(&mut session, |session| {
        session.master().download(Download::Scope { words: WORDS }).map_err(|error| error.to_string())?;
        let end = until(session, |session| {
            while session.master().poll_chunk().is_some() {}
            session.master().poll_download()
        });
        match end {
            Some(Ok(words)) if words == WORDS => Ok(()),
            other => Err(format!("the download ended with {other:?}")),
        }
    })?;
    let seconds = session.bench().time() - begun;
    let words = f64::from(WORDS);
    Ok(vec![
        Figure::new("download of a scope record of 4096 words, while the motor runs", seconds, "s"),
        Figure::new("words of the record", words / seconds, "1/s"),
        Figure::new("bus load without a download", 100.0 * idle, "%").note("500 kbit/s, every broadcast on"),
        Figure::new("bus load during the download", 100.0 * busy, "%").at_most(100.0),
        Figure::new("share of the bus that the download takes", 100.0 * (busy - idle), "%"),
        Figure::new(
            "the record's bits, of what the bus carries in that time",
            1600.0 * words / (seconds * 500e3),
            "%",
        ),
    ])
}

/// Runs `work`; returns the share of the time in which the bus was busy.
fn load(session: &mut Session, work: impl FnOnce(&mut Session) -> Result<(), String>) -> Result<f64, String> {
    let (before, from) = (session.bench().bus_statistics(), session.bench().now_ns());
    work(session)?;
    Ok(session.bench().bus_statistics().load_since(&before, session.bench().now_ns() - from))
}

fn ask(session: &mut Session, request: Request) -> Result<(), String> {
    session.master().request(request).map_err(|error| error.to_string())?;
    let answer = until(session, |session| session.master().poll_answer());
    let answer = answer.ok_or_else(|| format!("no answer to {request:?}"))?;
    answer.result.map(drop).map_err(|error| format!("{request:?}: {error:?}"))
}

fn until<T>(session: &mut Session, found: impl Fn(&mut Session) -> Option<T>) -> Option<T> {
    let end = session.bench().time() + PATIENCE;
    while session.bench().time() < end {
        session.step();
        if let Some(what) = found(session) {
            return Some(what);
        }
    }
    None
}
