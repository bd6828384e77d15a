use narx_core::motor::event::{Event, Status};
use narx_core::motor::{Drive, PwmCommand, Samples};
use narx_core::recording::{Recording, Replayable, replay_with};
use serde::Deserialize;
#[derive(Deserialize)]
struct P {
    drive: Drive,
    #[serde(skip)]
    last: Option<narx_core::motor::State>,
}
impl Replayable for P {
    fn handle_event(&mut self, event: Event) {
        self.drive.handle_event(event);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        let c = self.drive.step(samples);
        if (9190..9420).contains(&samples.tick) {
            println!(
                "{} {:?} {:?} {:?} {:?}",
                samples.tick,
                c.step,
                c.duty,
                samples.phase_voltage,
                self.drive.crossing()
            );
        }
        if self.last != Some(self.drive.state()) {
            self.last = Some(self.drive.state());
            println!("{} {:?}", samples.tick, self.drive.state());
        }
        c
    }
    fn poll_status(&mut self) -> Option<Status> {
        let s = self.drive.poll_status();
        if let Some(s) = &s
            && s.tick % 200 < 10
        {
            println!(
                "   {} {:?} sp {:?} v {:?} duty {:?} I {:?} {:?} why {:?} {} {:x}",
                s.tick,
                s.state,
                s.setpoint,
                s.speed_sensorless,
                s.duty,
                s.bus_current,
                s.limiter,
                s.crossing,
                s.crossings,
                s.extended_code
            );
        }
        s
    }
}
fn main() {
    let bytes = std::fs::read(std::env::args().nth(1).unwrap()).unwrap();
    let r = Recording::open(&bytes).unwrap();
    let o = replay_with(&r, |_: &P, _, _| ()).unwrap();
    println!("{}", o.ticks);
}
