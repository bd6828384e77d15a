//! Peace, after the faults: everything is repaired, and the drive has to work.

use super::neighbour::{self, Neighbour};
use super::never::{Checked, Never};
use super::world::{World, master};
use narx_core::bus::narmotion::DigitalOutputs;
use narx_core::commissioning::Mode;
use narx_core::dictionary::engineering;
use narx_core::dictionary::{Access, Parameters, number};
use narx_core::master::{Request, Service};
use narx_core::motor::State;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::event::{Refusal, Status};
use narx_sim::can::Attachment;

/// Longest time after the faults until a drive that was requested to go to Standby is there; below, until one
/// that was started turns, s. A fault waits for its acknowledgement, Auto-restart tries for its time, and a
/// rotor without friction turns for long.
const LONGEST: f64 = 12.0;
/// Time for two requests for Standby and the wait of a fault, or for the boot, s.
const ACKNOWLEDGED: f64 = 1.0;
const START: f64 = 20.0;
/// Time from the flash's report to the fault word, s.
const REPORTED: f64 = 0.1;
/// Time for an answer, s: a master repeats a request a few times before it gives up.
const ANSWER: f64 = 5.0;

impl World {
    /// Repairs everything; the operator requests Standby, and writes the parameters as they were
    /// commissioned.
    pub(super) fn make_peace(&mut self) -> Checked {
        self.say(|| "peace".into());
        self.cut_at = None;
        self.bench.flash().restore_power();
        self.bench.flash().set_absent(false);
        self.silent_until = 0;
        self.bench.disturb_bus(0, 0);
        self.bench.set_host(Attachment::Normal);
        self.bench.set_other(Attachment::Detached);
        self.bench.plant_mut().clear_all();
        self.bench.plant_mut().set_supply(self.setting.config.plant.supply);
        self.bench.plant_mut().set_load(self.setting.config.plant.load);
        self.master.abort_download();
        // A new master: pending requests of the old one no longer count.
        self.master = master(&self.bench);
        self.identification = None;
        // A threshold that the operator has changed may keep a fault present; it can be written in Fault,
        // too.
        let is_standby = |status: &Status| status.state == State::Standby;
        let rests = |status: &Status| is_standby(status) || status.state == State::Fault;
        let is_stopped = |status: &Status| is_standby(status) || status.standstill;
        self.run(ACKNOWLEDGED)?;
        if !self.until(LONGEST, rests)? {
            return Never::Standby.broken(format!("asked for Standby it is in {:?}", self.bench.status()));
        }
        self.ask(Request::DisableHallSupply(false))?;
        self.ask(Request::DigitalOutputs(DigitalOutputs::default()))?;
        // Sensors whose supply is back show another sector; a rotor that may have moved counts as standing
        // only after the time of parameter 113.
        if !self.until(LONGEST, is_stopped)? {
            return Never::Standby
                .broken(format!("its rotor is not known to stand: {:?}", self.bench.status()));
        }
        let parameters = self.setting.commissioning.parameters.clone();
        self.write_all(&parameters)?;
        self.store()?;
        if !self.until(LONGEST, is_standby)? {
            return Never::Standby.broken(format!("all is mended, and it is in {:?}", self.bench.status()));
        }
        Ok(())
    }

    /// Stores the parameters in a drive that found none at power-up, so that it keeps them. Once a second the
    /// drive checks whether its flash is back.
    fn store(&mut self) -> Checked {
        let absent = |world: &Self| world.bench.status().faults.contains(FaultWord::STORE_ABSENT);
        let until = self.ticks + self.ticks_in(LONGEST);
        while absent(self) && self.ticks < until {
            self.tick()?;
        }
        if self.bench.status().faults.intersects(FaultWord::STORE) {
            self.say(|| "all is stored".into());
            self.ask(Request::Run(Service::Store))?;
        }
        self.run(REPORTED)?;
        self.watch.hold_store();
        Ok(())
    }

    /// Waits for a state; returns false if it is not reached.
    fn until(&mut self, seconds: f64, holds: impl Fn(&Status) -> bool) -> Checked<bool> {
        let until = self.ticks + self.ticks_in(seconds);
        while !holds(self.bench.status()) && self.ticks < until {
            self.tick()?;
        }
        Ok(holds(self.bench.status()))
    }

    /// Writes every parameter that differs; commands, and parameters that the drive alone writes, are left
    /// out.
    fn write_all(&mut self, parameters: &Parameters) -> Checked {
        for (row, raw) in parameters.iter() {
            let now = self.bench.node().parameters().raw(row.number);
            if row.access == Access::ReadOnly || row.command || now == raw {
                continue;
            }
            self.write(row.number, raw)?;
        }
        Ok(())
    }

    fn write(&mut self, number: u16, raw: i32) -> Checked {
        let request = Request::Write { number, raw };
        match self.ask(request) {
            // The set that one write has completed may bring a fault, in which nothing is written until the
            // rotor is known to stand.
            Err((Never::Answers, _)) if self.bench.status().state == State::Fault => {
                self.until(LONGEST, |status| status.standstill)?;
                self.ask(request)?;
            }
            asked => asked?,
        }
        if self.bench.node().parameters().raw(number) == raw {
            return Ok(());
        }
        Never::Answers.broken(format!("parameter {number} does not become {raw}"))
    }

    /// Sends a request, and waits for the answer.
    fn ask(&mut self, request: Request) -> Checked {
        self.answer = None;
        if let Err(error) = self.master.request(request) {
            return Never::Answers.broken(format!("{request:?}: {error:?}"));
        }
        for _ in 0..self.ticks_in(ANSWER) {
            self.tick()?;
            if let Some(answer) = self.answer.take() {
                return match answer.result {
                    Ok(_) => Ok(()),
                    Err(error) => {
                        let (status, shaft) = (self.bench.status(), self.bench.plant().observe().speed);
                        Never::Answers.broken(format!("{request:?}: {error}; {shaft:.2} rad/s, {status:?}"))
                    }
                };
            }
        }
        Never::Answers.broken(format!("{request:?}: no end within {ANSWER} s"))
    }

    /// Checks that the drive starts, and turns as requested, if a drive without faults in its past does: some
    /// motors in open loop return more energy than a source that cannot sink current can take.
    pub(super) fn work(&mut self) -> Checked {
        if self.turns()? {
            return Ok(());
        }
        let status = format!("{:?}", self.bench.status());
        let mut setting = self.setting.clone();
        let electrical = self.begun_at * f64::from(setting.config.plant.motor.pole_pairs);
        setting.config.plant.angle_deg = electrical.to_degrees().rem_euclid(360.0);
        let mut untouched = Self::of(self.seed, self.tell, self.fate.clone(), setting);
        untouched.say(|| "another drive, to which nothing has happened".into());
        untouched.run(ACKNOWLEDGED)?;
        if untouched.turns()? {
            return Never::Turns.broken(format!("all is mended, and it does not turn: {status}"));
        }
        self.unable = true;
        Ok(())
    }

    /// Checks that the second drive turns its motor, unless a stray frame has changed its parameters.
    pub(super) fn neighbour_works(&mut self) -> Checked {
        let Some(neighbour) = &mut self.neighbour else { return Ok(()) };
        if neighbour.is_changed() {
            return Ok(());
        }
        neighbour.make_peace();
        self.say(|| "the second drive is started".into());
        let until = self.ticks + self.ticks_in(neighbour::PEACE);
        while self.ticks < until {
            self.tick()?;
            if self.neighbour.as_ref().is_some_and(Neighbour::turns) {
                return Ok(());
            }
        }
        let status = self.neighbour.as_ref().map(Neighbour::status);
        Never::Turns.broken(format!("the second drive does not turn: {status:?}"))
    }

    /// Starts the drive; returns whether it turns.
    fn turns(&mut self) -> Checked<bool> {
        let rpm = if self.setting.mode == Mode::OpenLoop {
            engineering::value(&self.setting.commissioning.parameters, number::OPEN_LOOP_SPEED).unwrap_or(0.0)
        } else {
            0.5 * (self.setting.commissioning.speed_min + self.setting.commissioning.speed_max)
        };
        // The first start may calibrate the hall sensors, if that was requested; it ends in Standby.
        for _ in 0..2 {
            self.say(|| format!("start {rpm:.0} rpm"));
            self.begun_at = self.bench.plant().observe().angle;
            self.master.start(rpm as i32);
            let until = self.ticks + self.ticks_in(START);
            while self.ticks < until && self.bench.status().refusal != Refusal::NoFreshRequest {
                self.tick()?;
                let speed = self.bench.plant().observe().speed * 60.0 / std::f64::consts::TAU;
                if (speed / rpm - 1.0).abs() < 0.05 {
                    self.say(|| format!("turns at {speed:.0} rpm"));
                    return Ok(true);
                }
            }
            self.master.stop();
            self.run(ACKNOWLEDGED)?;
        }
        Ok(false)
    }
}
