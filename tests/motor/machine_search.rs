//! Tests of the state machine around the table, explored breadth first to a fixpoint.
//!
//! A node has the machine's whole memory (in its serialised form) as at the clock's beginning. Its three
//! times are cut off above every threshold with which they are compared, which loses nothing. It also has a
//! few ghosts: history that the specification refers to, kept by the test alone. From each node every event
//! and every tick (512 combinations of inputs and enables) is tried.

use narx_core::motor::clock::Instant;
use narx_core::motor::machine::MachineCoefficients;
use narx_core::motor::machine::event::{Command, Refusal, RunRequest};
use narx_core::motor::machine::state::Conditions;
use narx_core::motor::machine::{Change, Inputs, Machine};
use narx_core::motor::{Direction, State};
use narx_core::units::ElectricalSpeed;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::sync::LazyLock;

/// The machine's memory, field by field in the order of its layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Memory {
    pub(crate) state: State,
    pub(crate) at: Instant,
    pub(crate) age: u32,
    pub(crate) command: Command,
    pub(crate) command_age: u32,
    pub(crate) due: Instant,
    pub(crate) armed: bool,
    pub(crate) acknowledged: bool,
    pub(crate) direction: Direction,
    pub(crate) mode: Conditions,
    pub(crate) sensorless: bool,
    pub(crate) calibrate: bool,
    pub(crate) refusal: Refusal,
    pub(crate) other_source: bool,
}

/// Durations in ticks. Each is long enough for a tick in which nothing else ends, and for one in which the
/// machine rests.
pub(crate) const BOOT: u32 = 3;
const LOCK: u32 = 3;
const RAMP: u32 = 3;
const WAIT: u32 = 2;
const TIMEOUT: u32 = 4;
/// Age above every threshold.
const AGE_MAX: u32 = 5;

pub(crate) fn coefficients(enables: u8) -> MachineCoefficients {
    MachineCoefficients {
        open_loop_enable: enables & 1 != 0,
        sensorless_enable: enables & 2 != 0,
        hall_enable: enables & 4 != 0,
        boot: BOOT,
        lock: LOCK,
        open_loop: RAMP,
        auto_restart: RAMP,
        fault_wait: WAIT,
        command_timeout: TIMEOUT,
        ..MachineCoefficients::default()
    }
}

/// Present instant of every node: its next tick is the one after.
pub(crate) fn start() -> Instant {
    Instant::default()
}

pub(crate) fn memory(machine: &Machine) -> Memory {
    postcard::from_bytes(&bytes(machine)).unwrap()
}

/// Serialised form, with zeros to its end.
type Bytes = [u8; 64];

fn bytes(value: &impl Serialize) -> Bytes {
    let mut bytes = [0; 64];
    postcard::to_slice(value, &mut bytes).unwrap();
    bytes
}

pub(crate) fn machine(memory: &Memory) -> Machine {
    postcard::from_bytes(&bytes(memory)).unwrap()
}

/// History to which the specification refers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Ghost {
    /// A Drive request would be a fresh edge: Standby was requested since the last stop (or the direction was
    /// changed).
    fresh: bool,
    /// Standby was requested since the fault.
    standby_since_fault: bool,
    /// The present stop is the one tick of a reversal.
    reversing: bool,
}

#[derive(Clone, Copy, Debug)]
enum Input {
    Request(RunRequest),
    Calibrate(bool),
    Offer(bool),
    Tick { bits: u8, enables: u8 },
}

pub(crate) fn inputs(bits: u8) -> Inputs {
    let bit = |n: u8| bits & (1 << n) != 0;
    Inputs {
        critical: bit(0),
        unhealthy: bit(1),
        causes_gone: bit(2),
        stopped: bit(3),
        calibrated: bit(4),
        parameters_fit: bit(5),
    }
}

fn all_inputs() -> Vec<Input> {
    let requests = [RunRequest::Standby, RunRequest::Drive, RunRequest::Reverse, RunRequest::Shutdown]
        .map(Input::Request);
    let ticks = (0..64).flat_map(|bits| (0..8).map(move |enables| Input::Tick { bits, enables }));
    let switches = [true, false].into_iter().flat_map(|on| [Input::Calibrate(on), Input::Offer(on)]);
    requests.into_iter().chain(switches).chain(ticks).collect()
}

/// Memory with its ages as of `now`.
pub(crate) fn as_of(now: Instant, mut memory: Memory) -> Memory {
    let passed = now.since(memory.at);
    memory.age = memory.age.saturating_add(passed);
    memory.command_age = memory.command_age.saturating_add(passed);
    memory.at = now;
    memory
}

/// Memory at `now`, moved to the clock's beginning: only distances between instants count.
fn bounded(now: Instant, memory: Memory) -> Memory {
    let mut memory = as_of(now, memory);
    memory.age = memory.age.min(AGE_MAX);
    memory.command_age = memory.command_age.min(AGE_MAX);
    memory.at = start();
    // An event that is due in the next tick stays due, and no duration is longer than the longest time.
    let left = if memory.due.is_due(now.next()) { 0 } else { memory.due.since(now) };
    memory.due = start().after(if left > AGE_MAX { u32::MAX } else { left });
    memory
}

pub(crate) fn wanted(request: RunRequest) -> Option<Direction> {
    match request {
        RunRequest::Drive => Some(Direction::Forward),
        RunRequest::Reverse => Some(Direction::Reverse),
        RunRequest::Standby | RunRequest::Shutdown => None,
    }
}

/// All reached nodes, with the number of edges tried.
struct Explored {
    nodes: Vec<(Memory, Ghost)>,
    edges: u64,
    pairs: HashSet<(State, State)>,
}

/// Everything that is reached from power-up.
fn explored() -> &'static Explored {
    static EXPLORED: LazyLock<Explored> = LazyLock::new(explore);
    &EXPLORED
}

fn explore() -> Explored {
    let first = (
        bounded(start(), memory(&Machine::default())),
        Ghost { fresh: true, standby_since_fault: false, reversing: false },
    );
    let mut seen = HashSet::from([(bytes(&first.0), first.1)]);
    let mut explored = Explored { nodes: vec![first], edges: 0, pairs: HashSet::new() };
    let all = all_inputs();
    // Nodes are added while they are looked at.
    let mut place = 0;
    while let Some((before, ghost)) = explored.nodes.get(place).cloned() {
        place += 1;
        let unchanged = machine(&before);
        // Most inputs of a node lead to one of a few others.
        let mut found = Vec::new();
        for input in &all {
            let mut after = unchanged;
            let mut ghost_after = ghost;
            let mut now = start();
            match *input {
                Input::Request(request) => {
                    after.handle_command(now, Command { request, speed: ElectricalSpeed::ZERO });
                    ghost_after = ghost_request(before.state, request, ghost);
                }
                Input::Calibrate(run) => after.handle_calibration(run),
                // The drive offers it in the closed loops alone, and each transition takes it back.
                Input::Offer(_)
                    if ![State::HallClosedLoop, State::SensorlessClosedLoop].contains(&before.state) =>
                {
                    continue;
                }
                Input::Offer(offered) => after.offer_other_source(offered),
                Input::Tick { bits, enables } => {
                    let inputs = inputs(bits);
                    let change = tick(&mut after, &inputs, enables);
                    now = now.next();
                    if let Some(change) = change {
                        explored.pairs.insert((change.row.from, change.row.to));
                    }
                    ghost_after = ghost_tick(&before, inputs, enables, after.state(), ghost);
                }
            }
            explored.edges += 1;
            if found.contains(&(now, after, ghost_after)) {
                continue;
            }
            found.push((now, after, ghost_after));
            let after = bounded(now, memory(&after));
            if seen.insert((bytes(&after), ghost_after)) {
                explored.nodes.push((after, ghost_after));
            }
        }
    }
    explored
}

/// Runs the tick after [`start`] as the drive does, which wakes a machine whose health has changed.
fn tick(machine: &mut Machine, inputs: &Inputs, enables: u8) -> Option<Change> {
    if inputs.unhealthy {
        machine.wake(start());
    }
    machine.step(&coefficients(enables), start().next(), inputs)
}

/// Every memory that the machine can reach.
pub(crate) fn reached() -> &'static [Memory] {
    static REACHED: LazyLock<Vec<Memory>> = LazyLock::new(|| {
        let mut seen = HashSet::new();
        let memories = explored().nodes.iter().map(|(memory, _)| memory);
        memories.filter(|memory| seen.insert(bytes(memory))).cloned().collect()
    });
    &REACHED
}

/// Applies decision 5: a Drive request during Initialization uses up the edge that power-up counts as.
fn ghost_request(state: State, request: RunRequest, mut ghost: Ghost) -> Ghost {
    match request {
        RunRequest::Standby => {
            ghost.fresh |= !state.is_driving();
            ghost.standby_since_fault |= state == State::Fault;
        }
        RunRequest::Drive | RunRequest::Reverse => ghost.fresh &= state != State::Initialization,
        RunRequest::Shutdown => {}
    }
    ghost
}

/// Applies decision 5: an edge that meets a refusal (no mode, parameters that do not fit) is used up by it.
fn ghost_tick(before: &Memory, inputs: Inputs, enables: u8, to: State, mut ghost: Ghost) -> Ghost {
    let from = before.state;
    let (open_loop, sensorless, hall) = (enables & 1 != 0, enables & 2 != 0, enables & 4 != 0);
    let able = inputs.parameters_fit && (before.calibrate || hall || open_loop || sensorless);
    if from == State::Standby && wanted(before.command.request).is_some() && !able {
        ghost.fresh = false;
    }
    let reversal = wanted(before.command.request).is_some_and(|direction| direction != before.direction);
    ghost.reversing = from.is_driving() && to == State::Standby && reversal;
    if from.is_driving() && to == State::Standby {
        ghost.fresh = before.command.request == RunRequest::Standby || reversal;
    }
    if to.is_driving() || to == State::Fault {
        ghost.fresh = false;
    }
    if from != State::Fault {
        ghost.standby_since_fault = false;
    }
    // Acknowledged while Drive is requested again: Standby must be requested once more.
    if from == State::Fault && to == State::Standby {
        ghost.fresh = before.command.request == RunRequest::Standby;
    }
    ghost
}

#[test]
fn memory_is_read_whole() {
    let machine_before = Machine::default();
    assert_eq!(bytes(&memory(&machine_before)), bytes(&machine_before));
    assert_eq!(machine(&memory(&machine_before)), machine_before);
}

#[test]
fn invariants_hold_in_every_reachable_state() {
    let explored = explored();
    for &(ref before, ghost) in &explored.nodes {
        let unchanged = machine(before);
        for (bits, enables) in (0..64).flat_map(|bits| (0..8).map(move |enables| (bits, enables))) {
            let inputs = inputs(bits);
            let mut after = unchanged;
            let change = tick(&mut after, &inputs, enables);
            let context = || format!("{before:?} {ghost:?} {inputs:?} enables {enables:03b} -> {after:?}");
            check_stops(before, &inputs, &after, change, &context);
            check_start(before, ghost, &inputs, enables, &after, &context);
            check_fault(before, ghost, &inputs, &after, change, &context);
            check_reversal(before, ghost, &inputs, enables, &after, &context);
        }
    }
    let states: HashSet<State> = explored.nodes.iter().map(|(memory, _)| memory.state).collect();
    println!("{} machine states, {} edges to the fixpoint", explored.nodes.len(), explored.edges);
    let mut pairs: Vec<_> = explored.pairs.iter().collect();
    pairs.sort_by_key(|(from, to)| (*from as u8, *to as u8));
    println!("transitions reached: {pairs:?}");
    assert_eq!(states, HashSet::from(State::ALL));
}

/// Checks critical fault, Standby request and time-out, in this order and in the same tick.
fn check_stops(
    before: &Memory,
    inputs: &Inputs,
    after: &Machine,
    change: Option<Change>,
    context: &impl Fn() -> String,
) {
    let driving = before.state.is_driving();
    let judged = driving || before.state == State::Standby;
    let request = before.command.request;
    let expired = before.command_age + 1 >= TIMEOUT;
    if judged && inputs.critical {
        assert_eq!(after.state(), State::Fault, "a fault wins in the same tick: {}", context());
    } else if driving && request == RunRequest::Standby {
        assert_eq!(after.state(), State::Standby, "Standby stops: {}", context());
    } else if driving && request == RunRequest::Shutdown {
        assert!(!after.state().is_driving(), "a shutdown request stops, masked or not: {}", context());
    } else if driving && expired {
        assert_eq!(after.state(), State::Fault, "silence stops: {}", context());
        assert!(change.is_some_and(|change| change.timed_out), "it has a name: {}", context());
    } else {
        assert!(!change.is_some_and(|change| change.timed_out), "no time-out: {}", context());
    }
    // With any request and any rotation it takes half a second, and no longer.
    if before.state == State::Initialization {
        let expected = match inputs.unhealthy {
            true => State::Fault,
            false if before.age + 1 >= BOOT => State::Standby,
            false => State::Initialization,
        };
        assert_eq!(after.state(), expected, "T01, T06: {}", context());
    }
}

/// Checks that Standby is left only with a fresh edge, a live command, parameters that fit, by Table 6, and
/// with the enables as sampled.
fn check_start(
    before: &Memory,
    ghost: Ghost,
    inputs: &Inputs,
    enables: u8,
    after: &Machine,
    context: &impl Fn() -> String,
) {
    let (open_loop, sensorless, hall) = (enables & 1 != 0, enables & 2 != 0, enables & 4 != 0);
    let request = wanted(before.command.request);
    let expired = before.command_age + 1 >= TIMEOUT;
    let able = request.is_some() && inputs.parameters_fit && !inputs.critical && !expired;
    let mode = before.calibrate || hall || open_loop || sensorless;
    if before.state == State::Standby {
        let starts = after.state().is_driving();
        assert_eq!(starts, able && ghost.fresh && mode, "a start needs all of it: {}", context());
        if starts {
            let wanted_state = match (before.calibrate, hall, sensorless) {
                (true, _, _) | (false, false, true) => State::RotorLock,
                (false, true, _) => State::HallClosedLoop,
                (false, false, false) => State::OpenLoop,
            };
            assert_eq!(after.state(), wanted_state, "Table 6: {}", context());
            assert_eq!(Some(after.direction()), request, "{}", context());
        }
        // Decision 2.
        if ghost.fresh && request.is_some() && inputs.parameters_fit && !before.calibrate {
            let refusal = match (hall, sensorless, open_loop) {
                (false, false, false) => Refusal::NoMode,
                _ => Refusal::None,
            };
            assert_eq!(after.refusal(), refusal, "{}", context());
        }
    } else if !before.state.is_driving() {
        assert!(!after.state().is_driving(), "only Standby leads to a driving state: {}", context());
    }
    if before.state.is_driving() {
        // The sampled enables decide, not the present ones.
        let mut other = machine(before);
        tick(&mut other, inputs, !enables & 7);
        assert_eq!(other, *after, "enables are sampled: {}", context());
    }
}

/// Checks T61: the wait has elapsed, the causes are gone, Standby was requested since, nothing is critical
/// now; and nothing else leaves Fault.
fn check_fault(
    before: &Memory,
    ghost: Ghost,
    inputs: &Inputs,
    after: &Machine,
    change: Option<Change>,
    context: &impl Fn() -> String,
) {
    if before.state != State::Fault {
        return;
    }
    let cured = ghost.standby_since_fault && before.age + 1 >= WAIT && inputs.causes_gone && !inputs.critical;
    let expected = if cured { State::Standby } else { State::Fault };
    assert_eq!(after.state(), expected, "T61: {}", context());
    assert_eq!(change.is_some(), cured, "{}", context());
}

/// Checks that a direction changes in Standby only, and that a reversal spends exactly one tick there.
fn check_reversal(
    before: &Memory,
    ghost: Ghost,
    inputs: &Inputs,
    enables: u8,
    after: &Machine,
    context: &impl Fn() -> String,
) {
    if before.state.is_driving() && after.state().is_driving() {
        assert_eq!(before.direction, after.direction(), "never plug: {}", context());
    }
    let reversal = wanted(before.command.request).is_some_and(|direction| direction != before.direction);
    let expired = before.command_age + 1 >= TIMEOUT;
    if before.state.is_driving() && reversal && !inputs.critical && !expired {
        let rests = inputs.stopped || before.state == State::RotorLock;
        let calibrated = before.mode.contains(Conditions::CALIBRATION) && inputs.calibrated;
        let leaves = rests || (before.state == State::OpenLoop && calibrated);
        // T74: closed loop slows down a motor that was caught.
        let caught =
            before.state == State::SensorlessAutoRestart && before.age + 1 >= RAMP && !inputs.stopped;
        let expected = match before.state {
            _ if leaves => State::Standby,
            _ if caught => State::SensorlessClosedLoop,
            state => state,
        };
        assert_eq!(after.state(), expected, "reversal: {}", context());
    }
    let healthy = inputs.parameters_fit && !inputs.critical && !expired;
    if before.state == State::Standby && ghost.reversing && healthy && enables & 4 != 0 && reversal {
        assert!(after.state().is_driving(), "one tick in Standby is the edge: {}", context());
        assert_eq!(Some(after.direction()), wanted(before.command.request), "{}", context());
    }
}
