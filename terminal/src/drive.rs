//! `drive`: a virtual drive in real time for other tools.

use crate::setup::{self, Refused, Setup, number};
use narx_host::serve::{Server, Speed, call, tx_drivers};
use narx_sim::tx_driver::TxDriverConfig;
use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Arguments of `drive`, as typed.
#[derive(clap::Args, Debug)]
pub struct Arguments {
    /// Motor, mode, supply, PWM rate and load of the bench
    #[command(flatten)]
    pub bench: setup::Arguments,
    /// TX-Drivers on the drive's bus: their node-ids (1 to 127), separated by commas, with :dual after those
    /// with two channels; each watches the shaft's surface and has an encoder on the shaft, with factory
    /// values otherwise
    #[arg(long, value_name = "N[:dual][,...]")]
    pub tx_drivers: Option<String>,
    /// Ratio of simulated to real time: a number, or max
    #[arg(long, allow_hyphen_values = true, default_value = "1")]
    pub speed: String,
    /// Address of the slcan server; port 0 takes a free one
    #[arg(long, default_value = "127.0.0.1:2000")]
    pub tcp: SocketAddr,
    /// Offer a pseudo-terminal, too
    #[arg(long)]
    pub pty: bool,
    /// Symbolic link to the pseudo-terminal
    #[arg(long, requires = "pty")]
    pub link: Option<PathBuf>,
    /// End after this much simulated time, s [default: runs until Ctrl-C]
    #[arg(long, allow_hyphen_values = true)]
    pub seconds: Option<String>,
    /// Print every second what the drive does, and which clients connect and disconnect
    #[arg(long, short)]
    pub verbose: bool,
}

/// Runs the drive until Ctrl-C; invalid arguments give exit code 2 and one line.
pub fn run(arguments: &Arguments) -> ExitCode {
    let settings = match Settings::new(arguments) {
        Ok(settings) => settings,
        Err(refused) => {
            eprintln!("{refused}");
            return ExitCode::from(2);
        }
    };
    match serve(arguments, settings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

/// Checked settings of a drive.
struct Settings {
    setup: Setup,
    tx_drivers: Vec<TxDriverConfig>,
    speed: Speed,
    /// Simulated time at which it ends, ns.
    end: u64,
}

impl Settings {
    fn new(arguments: &Arguments) -> Result<Self, Refused> {
        let setup = arguments.bench.check()?;
        let speed = match arguments.speed.as_str() {
            "max" => Speed::Unbound,
            text => Speed::Times(number("--speed", text, Speed::MIN, Speed::MAX, "or max")?),
        };
        let end = match &arguments.seconds {
            Some(text) => (number("--seconds", text, 0.001, 1e6, "s")? * 1e9) as u64,
            None => u64::MAX,
        };
        let tx_drivers = match &arguments.tx_drivers {
            Some(list) => tx_drivers::parse(list)
                .map_err(|allowed| Refused(format!("--tx-drivers {list}: {allowed}")))?,
            None => Vec::new(),
        };
        Ok(Self { setup, tx_drivers, speed, end })
    }
}

/// Opens the ports, prints their addresses, and runs the drive.
fn serve(arguments: &Arguments, settings: Settings) -> Result<(), String> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).map_err(|error| error.to_string())?;
    }
    let Settings { mut setup, tx_drivers, speed, end } = settings;
    setup.session.trace = false;
    let (mut bench, commissioning) = setup.session.power_up().map_err(|error| error.to_string())?;
    say(&format!("{}: {}, {}", setup.title(), setup.mode_name(), setup.conditions()));
    commissioning.notes.iter().for_each(|note| say(&format!("  note: {note}")));
    for driver in &tx_drivers {
        bench.add_tx_driver(driver).map_err(|error| error.to_string())?;
        say(&format!("  {}", tx_drivers::title(driver)));
    }

    let mut server = Server::new(bench, speed, end);
    let address =
        server.listen(arguments.tcp).map_err(|error| format!("--tcp {}: {error}", arguments.tcp))?;
    say(&format!("tcp  {}", call(&format!("socket://{address}"))));
    if arguments.pty {
        let path =
            server.open_terminal(arguments.link.as_deref()).map_err(|error| match &arguments.link {
                Some(link) => format!("--pty --link {}: {error}", link.display()),
                None => format!("--pty: {error}"),
            })?;
        say(&format!("pty  {}", call(&path.display().to_string())));
    }
    while !stop.load(Ordering::Relaxed) && server.step() {
        let news = server.take_news();
        if arguments.verbose {
            news.iter().for_each(|news| say(news));
        }
    }
    Ok(())
}

/// Prints a line for the user; if nothing reads the output, the drive runs on.
fn say(line: &str) {
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
