//! The SDO server: reads or writes one entry, or answers why not.

use super::TxDriver;
use super::objects::{Access, Entry, Kind};
use crate::bus::eddycan::{AbortCode, NmtState, SdoAction, SdoAnswer, SdoOutcome, SdoRequest, SdoValue};

impl TxDriver {
    /// Answers a request, unless the node is Stopped or the request is an abort. A request whose answer finds
    /// no room is not executed: every executed request is confirmed.
    pub(super) fn handle_sdo(&mut self, request: SdoRequest) {
        let silent = matches!(request.action, SdoAction::Abort { .. }) || self.state == NmtState::Stopped;
        if silent || !self.outbox.has_room() {
            return;
        }
        let outcome = self.serve(request).unwrap_or_else(|code| SdoOutcome::Aborted { code: code as u32 });
        let SdoRequest { index, subindex, .. } = request;
        self.outbox.put_answer(SdoAnswer { index, subindex, outcome });
    }

    fn serve(&mut self, request: SdoRequest) -> Result<SdoOutcome, AbortCode> {
        if self.state == NmtState::Operational {
            return Err(AbortCode::General);
        }
        let entry = || Entry::find(request.index, request.subindex);
        match request.action {
            SdoAction::Read => self.read(entry()?).map(SdoOutcome::Value),
            SdoAction::Write { size, data } => self.write(entry()?, size, data).map(|()| SdoOutcome::Written),
            SdoAction::Abort { .. } | SdoAction::Unknown { .. } => Err(AbortCode::CommandUnknown),
        }
    }

    fn read(&self, entry: Entry) -> Result<SdoValue, AbortCode> {
        let object = entry.object();
        let value = match entry {
            Entry::FirmwareVersion if !entry.is_blind() => self.variant.firmware.into(),
            _ => self.configuration.get(entry),
        };
        match (object.access, object.kind) {
            (Access::WriteOnly, _) => Err(AbortCode::WriteOnly),
            (_, Kind::U8) => Ok(SdoValue::byte(value as u8)),
            (_, Kind::U16) => Ok(SdoValue::word(value as u16)),
            (_, Kind::U32) => Ok(SdoValue::long(value)),
        }
    }

    fn write(&mut self, entry: Entry, size: Option<u8>, data: [u8; 4]) -> Result<(), AbortCode> {
        let object = entry.object();
        if object.access == Access::ReadOnly {
            return Err(AbortCode::ReadOnly);
        }
        if entry == Entry::ResetEncoder {
            // Only a linear encoder is reset: a rotary one cannot overflow.
            if self.configuration.encoder().counts_per_revolution.is_none() && !entry.is_blind() {
                self.sensing.reset_encoder();
            }
            return Ok(());
        }
        if size.is_some_and(|size| size != object.kind.size()) {
            return Err(AbortCode::General);
        }
        let [low, high, ..] = data;
        let value = match object.kind {
            Kind::U8 => low.into(),
            Kind::U16 => u16::from_le_bytes([low, high]).into(),
            Kind::U32 => u32::from_le_bytes(data),
        };
        let before = self.configuration;
        self.configuration.set(entry, value)?;
        self.store.note_write(self.configuration != before);
        self.sensing.configure(&self.variant, &self.configuration);
        Ok(())
    }
}
