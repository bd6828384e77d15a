//! Target: the master of a TX-Driver, with frames of a bus and orders of its caller in any order.

use crate::program::Program;
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{
    AbortCode, CobId, FromNode, Layout, NmtCommand, NmtState, NodeId, SdoAction, SdoAnswer, SdoOutcome,
    SdoValue, ToNode,
};
use narx_core::eddycan::OBJECTS;
use narx_core::master::eddycan::{Config, Request, TxMaster};

/// Runs an input. First two bytes: node-id and layout. Steps follow.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let node = NodeId::new(program.byte() & 0x7F).unwrap_or(NodeId::FACTORY);
    let layout = Layout::ALL[usize::from(program.byte() % 4)];
    let mut caller = Caller {
        master: TxMaster::new(Config::new(node, layout)),
        node,
        now: 0,
        asked: Vec::new(),
        last: None,
    };
    while !program.is_over() {
        caller.handle(&mut program);
    }
    caller.finish();
}

struct Caller {
    master: TxMaster,
    node: NodeId,
    now: u64,
    /// Requests that were accepted, in their order.
    asked: Vec<Request>,
    /// Last request that was sent.
    last: Option<ToNode>,
}

impl Caller {
    fn handle(&mut self, program: &mut Program<'_>) {
        match program.byte() % 7 {
            0 => self.master.handle_frame(&program.frame(), self.now),
            1 => self.pass(u64::from(program.byte()) * 500),
            2 => {
                let object = &OBJECTS[usize::from(program.byte()) % OBJECTS.len()];
                let request = match program.byte() & 1 {
                    0 => Request::Read(object.entry),
                    _ => Request::Write(object.entry, program.long()),
                };
                if self.master.request(request).is_ok() {
                    self.asked.push(request);
                }
            }
            3 => {
                let what = program.byte();
                let _ = match what >> 2 & 3 {
                    0 => self.master.command(NmtCommand::ALL[usize::from(what & 3)]),
                    1 => self.master.command_all(NmtCommand::ALL[usize::from(what & 3)]),
                    2 => self.master.sync(),
                    _ => self.master.ask_positions(),
                };
            }
            // An answer of a node, to the last request or to another.
            4 => {
                let (what, data) = (program.byte(), program.long());
                let Some(ToNode::Sdo { request, .. }) = self.last else { return };
                let outcome = match what & 7 {
                    0..=2 => SdoOutcome::Written,
                    3 => SdoOutcome::Value(SdoValue::byte(data as u8)),
                    4 => SdoOutcome::Value(SdoValue::word(data as u16)),
                    5 => SdoOutcome::Value(SdoValue::long(data)),
                    6 => SdoOutcome::Aborted { code: AbortCode::ALL[data as usize % 7] as u32 },
                    _ => SdoOutcome::Aborted { code: data },
                };
                let index = request.index ^ u16::from(what >> 3 & 1);
                self.receive(FromNode::Sdo(SdoAnswer { index, subindex: request.subindex, outcome }));
            }
            5 => {
                let state = NmtState::ALL[usize::from(program.byte() % 4)];
                self.receive(FromNode::Heartbeat(state));
            }
            _ => {
                let taken = self.master.poll_answer();
                self.take(taken);
            }
        }
    }

    fn receive(&mut self, message: FromNode) {
        let frame = message.encode(self.node, self.master.config().layout);
        self.master.handle_frame(&frame, self.now);
        assert!(self.master.is_present(self.now));
    }

    fn pass(&mut self, microseconds: u64) {
        self.now += microseconds;
        let mut sent = 0;
        while let Some(frame) = self.master.poll_frame(self.now) {
            self.said(&frame);
            sent += 1;
            assert!(sent <= 8, "{sent} frames at once");
        }
        assert!(self.master.next_poll(self.now) >= self.now);
    }

    fn said(&mut self, frame: &Frame) {
        let message = ToNode::decode(frame).expect("a message of a master");
        assert_eq!(message.encode(), *frame);
        if let ToNode::Sdo { node, request } = message {
            assert_eq!(node, self.node);
            assert!(matches!(request.action, SdoAction::Read | SdoAction::Write { .. }));
            self.last = Some(message);
        }
        assert!(
            matches!(CobId::decode(frame.id()), Ok(id) if !matches!(id, CobId::SdoAnswer(_) | CobId::Heartbeat(_)))
        );
    }

    /// Checks that answers come in the order of the requests.
    fn take(&mut self, answer: Option<narx_core::master::eddycan::Answer>) {
        if let Some(answer) = answer {
            assert_eq!(answer.request, self.asked.remove(0));
        }
    }

    /// Runs with a silent bus: every request is answered, in no more time than the attempts take.
    fn finish(&mut self) {
        let Config { timeout, attempts, .. } = *self.master.config();
        for _ in 0..=(self.asked.len() as u64 + 1) * (u64::from(attempts) + 1) {
            self.pass(timeout.max(3_000));
            while let answer @ Some(_) = self.master.poll_answer() {
                self.take(answer);
            }
        }
        assert_eq!(self.asked, [], "requests without an answer");
        assert!(self.master.poll_frame(self.now).is_none());
    }
}
