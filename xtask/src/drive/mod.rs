//! A virtual drive for everybody's tools: the bench in step with the clock on the wall, its bus as slcan over TCP and a pseudo-terminal.
//!
//! ```text
//!   TCP client  <─> reader, writer ─┐             ┌─> arbitration ─> simulated bus <─> drive, plant
//!   TCP client  <─> reader, writer ─┼─> adapters ─┤                       │
//!   terminal    <─> reader, writer ─┘             └──── all but its sender ┘
//!      threads                              one thread, held back by `Pace`
//! ```

mod client;
mod hub;
mod pace;
#[cfg(unix)]
mod pty;
mod tcp;
#[cfg(test)]
mod tests;
mod tx_drivers;

use crate::setup::{self, Refused, Setup, number};
use client::Connection;
use hub::Hub;
use narx_sim::tx_driver::TxDriverConfig;
use pace::{Pace, Speed};
use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Arguments of `drive`, as typed.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// What stands on the bench
    #[command(flatten)]
    pub bench: setup::Arguments,
    /// TX-Drivers on the drive's bus, by their node-ids (1 to 127), with commas between, :dual behind those with two channels; each looks at the shaft's
    /// surface and has an encoder on the shaft, with factory values otherwise
    #[arg(long, value_name = "N[:dual][,...]")]
    pub tx_drivers: Option<String>,
    /// Simulated over real time: a number, or max
    #[arg(long, allow_hyphen_values = true, default_value = "1")]
    pub speed: String,
    /// Address of the slcan server; port 0 takes a free one
    #[arg(long, default_value = "127.0.0.1:2000")]
    pub tcp: SocketAddr,
    /// Offer a pseudo-terminal, too
    #[arg(long)]
    pub pty: bool,
    /// A symbolic link to the pseudo-terminal
    #[arg(long, requires = "pty")]
    pub link: Option<PathBuf>,
    /// Ends after so much simulated time, s [default: runs until Ctrl-C]
    #[arg(long, allow_hyphen_values = true)]
    pub seconds: Option<String>,
    /// Tell every second what the drive does, and who comes and goes
    #[arg(long, short)]
    pub verbose: bool,
}

/// Largest factor of `--speed`.
const SPEED_MAX: f64 = 100.0;
/// How long to sleep when simulated time has come as far as it may: a tenth of that is a control tick.
const SLEEP: Duration = Duration::from_millis(1);
/// Ticks between two looks at the clock and for new clients: 10 ms of simulated time.
const TICKS: u32 = 100;
/// From one line of `--verbose` to the next.
const TOLD: Duration = Duration::from_secs(1);

/// Runs the drive until Ctrl-C; exit code 2 and one line for arguments that cannot be.
pub fn run(arguments: &Arguments) -> ExitCode {
    let request = match Request::new(arguments) {
        Ok(request) => request,
        Err(refused) => {
            eprintln!("{refused}");
            return ExitCode::from(2);
        }
    };
    match serve(arguments, request) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

/// A drive that can be.
struct Request {
    setup: Setup,
    tx_drivers: Vec<TxDriverConfig>,
    speed: Speed,
    /// Simulated time at which it ends, ns.
    end: u64,
}

impl Request {
    fn new(arguments: &Arguments) -> Result<Self, Refused> {
        let setup = arguments.bench.check()?;
        let speed = match arguments.speed.as_str() {
            "max" => Speed::Unbound,
            text => Speed::Times(number("--speed", text, 0.01, SPEED_MAX, "or max")?),
        };
        let end = match &arguments.seconds {
            Some(text) => (number("--seconds", text, 0.001, 1e6, "s")? * 1e9) as u64,
            None => u64::MAX,
        };
        let tx_drivers = arguments.tx_drivers.as_deref().map_or_else(|| Ok(Vec::new()), tx_drivers::parse)?;
        Ok(Self { setup, tx_drivers, speed, end })
    }
}

/// Opens the doors, says where they are, and runs.
fn serve(arguments: &Arguments, request: Request) -> Result<(), String> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(|error| error.to_string())?;
    }
    let Request { mut setup, tx_drivers, speed, end } = request;
    setup.session.trace = false;
    let (mut bench, commissioning) = setup.session.power_up().map_err(|error| error.to_string())?;
    say(&format!(
        "{}: {}, {} V supply, {} N m load",
        setup.title(),
        setup.mode_name(),
        setup.supply,
        setup.load
    ));
    commissioning.notes.iter().for_each(|note| say(&format!("  note: {note}")));
    for driver in &tx_drivers {
        bench.add_tx_driver(driver).map_err(|error| error.to_string())?;
        say(&format!("  {}", tx_drivers::title(driver)));
    }

    let (door, connections) = mpsc::channel();
    let address =
        tcp::listen(arguments.tcp, door).map_err(|error| format!("--tcp {}: {error}", arguments.tcp))?;
    say(&format!("tcp  can.Bus(interface=\"slcan\", channel=\"socket://{address}\", bitrate=500000)"));
    let mut hub = Hub::new(bench.without_recording());
    // The terminal's path is taken back when this ends.
    let _terminal = terminal(arguments, &mut hub)?;

    run_until(&stop, end, &mut hub, Pace::new(speed), &connections, arguments.verbose);
    Ok(())
}

#[cfg(unix)]
fn terminal(arguments: &Arguments, hub: &mut Hub) -> Result<Option<pty::Terminal>, String> {
    if !arguments.pty {
        return Ok(None);
    }
    let refused = |error: io::Error| match &arguments.link {
        Some(link) => format!("--pty --link {}: {error}", link.display()),
        None => format!("--pty: {error}"),
    };
    let (terminal, connection) = pty::open(arguments.link.as_deref()).map_err(refused)?;
    say(&format!(
        "pty  can.Bus(interface=\"slcan\", channel=\"{}\", bitrate=500000)",
        terminal.path().display()
    ));
    hub.attach(connection);
    Ok(Some(terminal))
}

#[cfg(not(unix))]
fn terminal(arguments: &Arguments, _: &mut Hub) -> Result<(), String> {
    if arguments.pty { Err("--pty: this system has no pseudo-terminals".into()) } else { Ok(()) }
}

/// Simulates until it is stopped, or until `end`.
fn run_until(
    stop: &AtomicBool,
    end: u64,
    hub: &mut Hub,
    mut pace: Pace,
    connections: &Receiver<Connection>,
    verbose: bool,
) {
    let start = Instant::now();
    let mut told = Duration::ZERO;
    while !stop.load(Ordering::Relaxed) && hub.now_ns() < end {
        connections.try_iter().for_each(|connection| hub.attach(connection));
        let limits = pace.limits(start.elapsed(), hub.now_ns(), hub.busy_ns());
        let mut left = TICKS;
        while left > 0 && hub.now_ns() < limits.time.min(end) && hub.busy_ns() < limits.busy {
            hub.step();
            left -= 1;
        }
        let news = hub.take_news();
        if verbose {
            news.iter().for_each(|news| say(news));
            if start.elapsed() >= told + TOLD {
                told += TOLD;
                let behind = pace.behind_ns(hub.now_ns()) as f64 / 1e6;
                say(&format!("{}, {behind:.0} ms behind", hub.summary()));
            }
        }
        if left > 0 {
            thread::sleep(SLEEP);
        }
    }
}

/// A line for whoever started this; if he does not read it, the drive runs on.
fn say(line: &str) {
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
