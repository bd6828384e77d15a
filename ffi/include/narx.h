/**
 * @file
 * narx: the control core of a NarMotion-X drive for three-phase BLDC motors, in fixed point.
 *
 * Made from the library's sources by `cargo xtask header`: do not edit.
 *
 *
 * A drive
 *
 *     static narx_drive_t drive;
 *
 *     narx_drive_init(&drive, sizeof drive, NULL);        once
 *
 *     narx_drive_step(&drive, &samples, &command);        control interrupt, every PWM period
 *
 *     narx_drive_handle_frame(&drive, &frame);            main loop: for each received frame,
 *     narx_drive_run(&drive, tick);                       then once,
 *     while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) send(&frame);    then until it is empty
 *
 *
 * Other parts
 *
 *     narx_motor_*                                        the drive's control tick alone, without bus and
 *                                                         parameters, for little flash
 *     narx_storage_*                                      a drive's flash: stored parameters and the log
 *     narx_pi_*, _ramp_*, _hall_*, _zero_crossing_*,      the drive's blocks one by one, for a driver of
 *     _commutation_*, _fault_*, _state_*                  your own
 *     narx_q16_*, _iq24_*, _q15_*, _q12_*                 conversions between its number formats and yours
 *     narx_message_*, narx_tx_message_*                   decoding and encoding of frames
 *     narx_master_*                                       a drive's master, at the other end of the bus
 *     narx_identification_*, narx_commission,             a drive measures its motor; parameters for a
 *     narx_speed_loop                                     motor that is known
 *     narx_tx_driver_*, narx_tx_master_*                  the TX-Driver, another device, and its master
 *     narx_replay*                                        recordings
 *
 *
 * Calls that may interrupt each other
 *
 *     A drive has two halves that share nothing but queues. The tick half is narx_drive_step; the
 *     background half is every other narx_drive_* call. Either half may interrupt the other at any
 *     instruction, or run on another thread or processor. Within a half, calls for one drive must
 *     not interrupt each other. narx_drive_init, _init_stored and _attach_scope, and
 *     narx_storage_init_drive, must return before either half is called. narx_storage_serve belongs
 *     to the background half.
 *
 *     Any other object has one half: calls for one of them must not interrupt each other. A block's
 *     step function is called where you need it, mostly in the control interrupt; its init function
 *     is called at power-up. "Any context" marks a function that has no object at all.
 *
 *     Different objects share nothing: the library has no variables.
 *
 *
 * Memory
 *
 *     All memory is the caller's; the library has no heap. The only pointers that it keeps are those
 *     to the memory of a drive and of its scope: every other object may be freed when the call
 *     returns. A pointer points to readable (const) or writable memory of its type. The result is
 *     NARX_ERROR_NULL for NULL, unless the function gives NULL a meaning, NARX_ERROR_ALIGNMENT for a
 *     misaligned pointer, and NARX_ERROR_UNINITIALISED for an object that was not initialised.
 *     Zero the memory of an object before its first use, as static memory is. A call that returns an
 *     error has changed nothing.
 *
 *
 * Numbers
 *
 *     Q16 is I16F16: 65 536 is 1 V, A, degree Celsius or rev/s. Duty is U1F15: 32 768 is 1. Angles
 *     are unsigned parts of a turn and wrap. Instants are 1/65 536 of a PWM period. Converter codes
 *     are the raw results of the converter; narx_board_t has their scales. Parameters are raw
 *     integers; PROTOCOL.md lists their units and decimal scales.
 *
 *
 * Cost
 *
 *     Flash, RAM and instructions of each part on a Cortex-M: share/narx/sizes.toml of the archive. The drive
 *     itself costs some 310 instructions a tick with hall sensors, 480 without, 2 820 in the worst
 *     tick of all conformance vectors; narx_drive_step adds the
 *     conversion of the caller's structures. Link with --gc-sections.
 */

#ifndef NARX_H
#define NARX_H

#include "narx_types.h"

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Writes the step that gives torque in direction `towards` (0 forward, 1 reverse) to a rotor in `sector`, 0
/// to 5. Any context; no state.
narx_status_t narx_commutation_step_for(uint8_t sector,
                                        uint8_t towards,
                                        narx_step_t *step);

/// Writes the action of a step (a narx_step_t) on the legs of phases A, B, C into `legs`, 3 bytes: 0 both
/// switches off, 1 low side on, 2 switched with the duty. Any context; no state.
narx_status_t narx_commutation_legs(uint8_t step,
                                    uint8_t *legs);

/// Makes a commutation that knows no rotor position yet. Returns NARX_ERROR_SETTING if it cannot be built
/// from the settings; `error`, which may be NULL, then names the setting.
narx_status_t narx_commutation_init(struct narx_commutator_t *commutation,
                                    size_t size,
                                    const struct narx_commutation_settings_t *settings,
                                    struct narx_setting_error_t *error);

/// Makes a commutation that knows no rotor position yet from ready-made coefficients: what narx has computed
/// on the desk from such settings as narx_commutation_init takes. They are not checked. It takes a few
/// hundred bytes of flash where narx_commutation_init takes thousands.
narx_status_t narx_commutation_init_ready(struct narx_commutator_t *commutation,
                                          size_t size,
                                          const struct narx_commutator_coefficients_t *ready);

/// Writes the steps of this period for a rotor at `angle` (2^32 a turn) that turns with `turn_speed`
/// (2^-32 turn a tick, signed), both at the period's boundary, with torque in direction `towards` (0 forward,
/// 1 reverse). A rotor that seems to have fallen back by less than 15 degrees is not commutated back.
narx_status_t narx_commutation_step(struct narx_commutator_t *commutation,
                                    uint32_t angle,
                                    int32_t turn_speed,
                                    uint8_t towards,
                                    struct narx_steps_t *steps);

/// Forgets the sector; call it after the bridge was off.
narx_status_t narx_commutation_reset(struct narx_commutator_t *commutation);

/// Writes the drive's factory values at 10 kHz, as a start for your own settings; no speed counts as too
/// high.
narx_status_t narx_fault_settings_default(struct narx_fault_settings_t *settings);

/// Makes a fault logic without a fault. Returns NARX_ERROR_SETTING if it cannot be built from the settings;
/// `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_fault_init(struct narx_fault_t *fault,
                              size_t size,
                              const struct narx_fault_settings_t *settings,
                              struct narx_setting_error_t *error);

/// Makes a fault logic without a fault from ready-made coefficients: what narx has computed on the desk from
/// such settings as narx_fault_init takes. They are not checked. It takes a few hundred bytes of flash where
/// narx_fault_init takes thousands.
narx_status_t narx_fault_init_ready(struct narx_fault_t *fault,
                                    size_t size,
                                    const struct narx_protection_coefficients_t *ready);

/// Runs one tick. A critical fault latches.
narx_status_t narx_fault_step(struct narx_fault_t *fault,
                              const struct narx_evidence_t *evidence,
                              struct narx_faults_t *faults);

/// Follows a state change of the state machine beside it (narx_state_step): a time-out and a failed boot are
/// latched, leaving Fault acknowledges, and the plausibility checks of the sensors start anew in every driven
/// episode.
narx_status_t narx_fault_handle_change(struct narx_fault_t *fault,
                                       const struct narx_change_t *change,
                                       const struct narx_evidence_t *evidence);

/// Clears the latched faults if none of their causes is present any more; else returns NARX_ERROR_WRONG_STATE
/// and does nothing.
narx_status_t narx_fault_acknowledge(struct narx_fault_t *fault);

/// Writes default settings, as a start for your own: 10 kHz, lines in the order A, B, C, the factory's
/// time-out, interpolation from 1 rev/s, captured edges.
narx_status_t narx_hall_settings_default(struct narx_hall_settings_t *settings);

/// Makes a station that has not seen the sensors yet. Returns NARX_ERROR_SETTING if it cannot be built from
/// the settings; `error`, which may be NULL, then names the setting.
narx_status_t narx_hall_init(struct narx_hall_t *hall,
                             size_t size,
                             const struct narx_hall_settings_t *settings,
                             struct narx_setting_error_t *error);

/// Makes a station that has not seen the sensors yet from ready-made coefficients: what narx has computed on
/// the desk from such settings as narx_hall_init takes. They are not checked. It takes a few hundred bytes of
/// flash where narx_hall_init takes thousands.
narx_status_t narx_hall_init_ready(struct narx_hall_t *hall,
                                   size_t size,
                                   const struct narx_hall_ready_t *ready);

/// Runs one tick with the lines now (bit 0 = A, bit 1 = B, bit 2 = C) and the `count` edges of the period
/// that has ended, oldest first, at most NARX_EDGES_MAX; `edge` may be NULL if `count` is 0.
narx_status_t narx_hall_step(struct narx_hall_t *hall,
                             uint8_t code,
                             const struct narx_edge_t *edge,
                             size_t count,
                             struct narx_hall_reading_t *reading);

/// Makes a controller at rest: its integrator is 0. Returns NARX_ERROR_SETTING if it cannot be built from the
/// settings; `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_pi_init(struct narx_pi_t *pi,
                           size_t size,
                           const struct narx_pi_settings_t *settings,
                           struct narx_setting_error_t *error);

/// Makes a controller at rest from ready-made coefficients: what narx has computed on the desk from such
/// settings as narx_pi_init takes. They are not checked. It takes a few hundred bytes of flash where
/// narx_pi_init takes thousands.
narx_status_t narx_pi_init_ready(struct narx_pi_t *pi,
                                 size_t size,
                                 const struct narx_pi_ready_t *ready);

/// Writes the output for an error, both Q16: u = Kp e + integral of Ki e dt, within its limits. The
/// integrator never holds more than brings the output to a limit.
narx_status_t narx_pi_step(struct narx_pi_t *pi, int32_t error, int32_t *output);

/// Follows the output `applied` (Q16) that something else decided in this step, whose error was `error`. The
/// integrator goes an eighth of the way to the value that would have given `applied`, so that the controller
/// takes over again without a bump.
narx_status_t narx_pi_track(struct narx_pi_t *pi,
                            int32_t applied,
                            int32_t error);

/// Sets the integrator so that it alone gives `output` (Q16).
narx_status_t narx_pi_hold(struct narx_pi_t *pi, int32_t output);

/// Makes a ramp at 0. Returns NARX_ERROR_SETTING if it cannot be built from the settings; `error`, which may
/// be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_ramp_init(struct narx_ramp_t *ramp,
                             size_t size,
                             const struct narx_ramp_settings_t *settings,
                             struct narx_setting_error_t *error);

/// Makes a ramp at 0 from ready-made coefficients: what narx has computed on the desk from such settings as
/// narx_ramp_init takes. They are not checked. It takes a few hundred bytes of flash where narx_ramp_init
/// takes thousands.
narx_status_t narx_ramp_init_ready(struct narx_ramp_t *ramp,
                                   size_t size,
                                   const struct narx_ramp_ready_t *ready);

/// Moves one step towards `target` and writes the new value to `value`, both Q16.
narx_status_t narx_ramp_step(struct narx_ramp_t *ramp, int32_t target, int32_t *value);

/// Continues from `value`, Q16.
narx_status_t narx_ramp_set(struct narx_ramp_t *ramp, int32_t value);

/// Writes the drive's factory values at 10 kHz, with hall sensors, as a start for your own settings.
narx_status_t narx_state_settings_default(struct narx_state_settings_t *settings);

/// Makes a machine in Initialization. Returns NARX_ERROR_SETTING if it cannot be built from the settings;
/// `error`, which may be NULL, then names the setting.
narx_status_t narx_state_init(struct narx_state_machine_t *machine,
                              size_t size,
                              const struct narx_state_settings_t *settings,
                              struct narx_setting_error_t *error);

/// Makes a machine in Initialization from ready-made coefficients: what narx has computed on the desk from
/// such settings as narx_state_init takes. They are not checked. It takes a few hundred bytes of flash where
/// narx_state_init takes thousands.
narx_status_t narx_state_init_ready(struct narx_state_machine_t *machine,
                                    size_t size,
                                    const struct narx_machine_coefficients_t *ready);

/// Takes a command: `mode` is 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown, `speed` the electrical set-point,
/// Q16 rev/s. It restarts the command time-out. Standby acknowledges a fault; Drive and Reverse start the
/// motor if Standby was requested before.
narx_status_t narx_state_handle_command(struct narx_state_machine_t *machine,
                                        uint8_t mode,
                                        int32_t speed);

/// Runs one tick: time passes, and at most one transition fires. Returns NARX_OK and writes the transition to
/// `change`, or returns NARX_NOTHING.
narx_status_t narx_state_step(struct narx_state_machine_t *machine,
                              const struct narx_state_inputs_t *inputs,
                              struct narx_change_t *change);

/// Writes the present state of the machine.
narx_status_t narx_state_report(struct narx_state_machine_t *machine,
                                struct narx_state_report_t *report);

/// Writes default settings, as a start for your own: 10 kHz, narx's own converter, 4 codes of noise, 200 us
/// of blanking, samples, no delays, no advance, 500 ticks; the back-EMF is unknown.
narx_status_t narx_zero_crossing_settings_default(struct narx_zero_crossing_settings_t *settings);

/// Makes a detector that has not seen the motor yet. Returns NARX_ERROR_SETTING if it cannot be built from
/// the settings; `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
narx_status_t narx_zero_crossing_init(struct narx_zero_crossing_t *detector,
                                      size_t size,
                                      const struct narx_zero_crossing_settings_t *settings,
                                      struct narx_setting_error_t *error);

/// Makes a detector that has not seen the motor yet from ready-made coefficients: what narx has computed on
/// the desk from such settings as narx_zero_crossing_init takes. They are not checked. It takes a few hundred
/// bytes of flash where narx_zero_crossing_init takes thousands.
narx_status_t narx_zero_crossing_init_ready(struct narx_zero_crossing_t *detector,
                                            size_t size,
                                            const struct narx_zero_crossing_ready_t *ready);

/// Begins to bring up a rotor that rests at `angle` (2^32 a turn), in direction `towards` (0 forward, 1
/// reverse).
narx_status_t narx_zero_crossing_start(struct narx_zero_crossing_t *detector,
                                       uint32_t angle,
                                       uint8_t towards);

/// Goes on by a step without any evidence: the rotor that is being brought up has not moved.
narx_status_t narx_zero_crossing_force_step(struct narx_zero_crossing_t *detector);

/// Runs one tick with the samples (phase and bus voltages with their mode, edges of comparators) and the
/// pattern that was applied in the period that has ended, with torque in direction `towards` (0 forward, 1
/// reverse).
narx_status_t narx_zero_crossing_step(struct narx_zero_crossing_t *detector,
                                      const struct narx_samples_t *samples,
                                      const struct narx_applied_t *applied,
                                      uint8_t towards,
                                      struct narx_zero_crossing_reading_t *reading);

/// Writes the default board, as a start for your own: 10 kHz, a tick that takes at most 12.5 us, 500 ns dead
/// time, 12-bit converters to 80 V and +-16.4 A.
narx_status_t narx_board_default(struct narx_board_t *board);

/// Writes the measured figures and the supply into a nameplate; its rated current, largest set-point and PWM
/// rate become 0, its mode stays. Returns NARX_ERROR_ARGUMENT for a rotor that was held.
narx_status_t narx_nameplate_from_identified(struct narx_nameplate_t *nameplate,
                                             const struct narx_identified_t *identified);

/// Computes the parameters of a drive for a motor, by the design rules. `text`, of `size` bytes, gets a line
/// for each limit of the drive that holds the motor back; for NARX_ERROR_COMMISSIONING, a motor or a supply
/// that the drive cannot run, it gets the reason. It may be NULL if `size` is 0. Returns NARX_ERROR_ARGUMENT
/// for an undefined mode, NARX_ERROR_BOARD for a PWM rate. Not for an interrupt.
narx_status_t narx_commission(const struct narx_nameplate_t *nameplate,
                              struct narx_commissioned_t *commissioned,
                              char *text,
                              size_t size);

/// Computes a speed loop for a motor, with set-points from `speed_min`, mechanical rpm, on, and a bandwidth,
/// Hz; a bandwidth of 0 asks for the fastest that leaves 60 degrees of phase margin. For
/// NARX_ERROR_COMMISSIONING `text`, of `size` bytes, gets the reason; it may be NULL if `size` is 0.
narx_status_t narx_speed_loop(const struct narx_nameplate_t *nameplate,
                              double speed_min,
                              double bandwidth,
                              struct narx_speed_loop_t *speed_loop,
                              char *text,
                              size_t size);

/// Returns the bytes that a drive needs on this processor: at most NARX_DRIVE_SIZE. Any context.
size_t narx_drive_size(void);

/// Returns the alignment that a drive needs on this processor: at most that of narx_drive_t. Any context.
size_t narx_drive_align(void);

/// Makes a drive at power-up, with factory parameters, in `size` bytes of memory (sizeof(narx_drive_t), or
/// narx_drive_size() in memory of your own). `board` is NULL for the default board. The previous content of
/// the memory is lost. If it was a drive, this reboots it.
///
/// Call it before any other use, not during another call for the same drive. A narx_drive_step that
/// interrupts it returns NARX_ERROR_UNINITIALISED and writes a coast command.
narx_status_t narx_drive_init(struct narx_drive_t *drive,
                              size_t size,
                              const struct narx_board_t *board);

/// Makes a drive as narx_drive_init does, with stored parameters and an identity. `stored` has `count`
/// parameters and may be NULL if `count` is 0; `identity` may be NULL. A set is accepted or rejected as a
/// whole: with NARX_ERROR_UNKNOWN_PARAMETER or NARX_ERROR_OUT_OF_RANGE the memory is unchanged. If no working
/// controller can be built from an accepted set, the drive refuses to start;
/// NARX_PARAMETER_REJECTED_PARAMETER holds the number of the parameter.
narx_status_t narx_drive_init_stored(struct narx_drive_t *drive,
                                     size_t size,
                                     const struct narx_board_t *board,
                                     const struct narx_identity_t *identity,
                                     const struct narx_stored_t *stored,
                                     size_t count);

/// Runs one control tick: takes the samples of this period and writes the command to apply. Tick half: call
/// it from the control interrupt, once a PWM period. It may interrupt every other call for the same drive
/// except narx_drive_init and itself.
///
/// On an error the command, if `command` is a valid pointer, is coast at duty 0: a caller that ignores the
/// status still turns the bridge off.
narx_status_t narx_drive_step(struct narx_drive_t *drive,
                              const struct narx_samples_t *samples,
                              struct narx_pwm_command_t *command);

/// Takes a frame that has arrived. Frames that are not for this drive, or not well formed, are counted or
/// ignored (PROTOCOL.md). Background half.
narx_status_t narx_drive_handle_frame(struct narx_drive_t *drive,
                                      const struct narx_frame_t *frame);

/// Advances the drive's background to the control tick `now` and exchanges data with the tick half. Call it
/// once a period or less often, after narx_drive_handle_frame and before narx_drive_poll_frame. Background
/// half.
narx_status_t narx_drive_run(struct narx_drive_t *drive,
                             uint64_t now);

/// Writes the next frame to send, or returns NARX_NOTHING. Call it until it returns NARX_NOTHING. Background
/// half.
narx_status_t narx_drive_poll_frame(struct narx_drive_t *drive,
                                    struct narx_frame_t *frame);

/// Writes the next frame of a download that the master has requested, or returns NARX_NOTHING, as it does
/// while narx_drive_poll_frame has frames. Call it when no more than one frame is in the controller, the one
/// that is on the bus: more would delay the drive's other messages. A program that never calls it serves no
/// downloads. Background half.
narx_status_t narx_drive_poll_bulk_frame(struct narx_drive_t *drive,
                                         struct narx_frame_t *frame);

/// Writes a parameter as the master does: number, access, range and state are checked, then it takes effect
/// as described in PROTOCOL.md. `value` is the raw value, with the unit and scale of PROTOCOL.md; a 32-bit
/// unsigned value is passed as its bits. Background half.
narx_status_t narx_drive_set_parameter(struct narx_drive_t *drive,
                                       uint16_t number,
                                       int32_t value);

/// Reads a parameter, raw as in narx_drive_set_parameter, measured values included. Background half.
narx_status_t narx_drive_get_parameter(struct narx_drive_t *drive,
                                       uint16_t number,
                                       int32_t *value);

/// Returns the bytes that a TX-Driver needs on this processor: at most sizeof(narx_tx_driver_t). Any context.
size_t narx_tx_driver_size(void);

/// Makes a TX-Driver at power-up in `size` bytes of memory: sizeof(narx_tx_driver_t), or
/// narx_tx_driver_size() of your own. `values` are the NARX_TX_VALUES values that were stored, or NULL for
/// factory state. Returns NARX_ERROR_VARIANT if there is no such driver, NARX_ERROR_OUT_OF_RANGE for a stored
/// value outside the range of its entry.
narx_status_t narx_tx_driver_init(struct narx_tx_driver_t *driver,
                                  size_t size,
                                  const struct narx_tx_variant_t *variant,
                                  const uint32_t *values);

/// Takes a frame that arrived at `now`, microseconds. A frame for another node or of another protocol changes
/// nothing.
narx_status_t narx_tx_driver_handle_frame(struct narx_tx_driver_t *driver,
                                          const struct narx_frame_t *frame,
                                          uint64_t now);

/// Takes a sample, at the variant's rate: positions in 2^-27 mm (the second is ignored on a driver with one
/// channel), and the encoder's free-running counter, four counts to a period.
narx_status_t narx_tx_driver_handle_sample(struct narx_tx_driver_t *driver,
                                           int32_t position_1,
                                           int32_t position_2,
                                           uint16_t counter);

/// Takes the state of the CAN controller, as often as the board reads it. Off the bus no frame is handed out,
/// and positions and answers that wait are dropped; drop the frames that wait in the controller, too. An
/// error message among them is sent again.
narx_status_t narx_tx_driver_handle_bus_state(struct narx_tx_driver_t *driver,
                                              const struct narx_bus_state_t *state);

/// Advances time to `now`, microseconds.
narx_status_t narx_tx_driver_poll(struct narx_tx_driver_t *driver, uint64_t now);

/// Writes the latest time of the next poll, microseconds, if nothing is handled until then; UINT64_MAX for
/// never.
narx_status_t narx_tx_driver_next_poll(struct narx_tx_driver_t *driver,
                                       uint64_t *at);

/// Writes the next frame to send, or returns NARX_NOTHING.
narx_status_t narx_tx_driver_poll_frame(struct narx_tx_driver_t *driver,
                                        struct narx_frame_t *frame);

/// Writes the NARX_TX_VALUES values to store, or returns NARX_NOTHING. It hands out nothing more until
/// narx_tx_driver_handle_store was called with the result.
narx_status_t narx_tx_driver_poll_store(struct narx_tx_driver_t *driver,
                                        uint32_t *values);

/// Takes the result of storing the values of narx_tx_driver_poll_store: not 0 if they are stored. A board
/// that could not read its memory at power-up passes 0, too.
narx_status_t narx_tx_driver_handle_store(struct narx_tx_driver_t *driver,
                                          uint8_t done);

/// Returns NARX_OK, once, when the board must restart the driver now: call narx_tx_driver_init with the
/// stored values. Returns NARX_NOTHING otherwise.
narx_status_t narx_tx_driver_take_reset(struct narx_tx_driver_t *driver);

/// Writes the state that the board needs.
narx_status_t narx_tx_driver_report(struct narx_tx_driver_t *driver,
                                    struct narx_tx_driver_report_t *report);

/// Returns the bytes that a TX-Driver's master needs on this processor: at most sizeof(narx_tx_master_t). Any
/// context.
size_t narx_tx_master_size(void);

/// Makes the master of node `number` (1 to 127) with this layout, in `size` bytes of memory:
/// sizeof(narx_tx_master_t), or narx_tx_master_size() of your own. It sends nothing until it gets a command
/// or a request. It waits 100 ms for an answer, sends a request up to three times, and counts a node as gone
/// after 5 s without a message.
narx_status_t narx_tx_master_init(struct narx_tx_master_t *master,
                                  size_t size,
                                  uint8_t number,
                                  const struct narx_tx_layout_t *layout);

/// Takes a frame that arrived at `now`, microseconds. Frames of other nodes are ignored.
narx_status_t narx_tx_master_handle_frame(struct narx_tx_master_t *master,
                                          const struct narx_frame_t *frame,
                                          uint64_t now);

/// Writes the next frame that is due at `now`, microseconds, or returns NARX_NOTHING.
narx_status_t narx_tx_master_poll_frame(struct narx_tx_master_t *master,
                                        uint64_t now,
                                        struct narx_frame_t *frame);

/// Writes the latest time of the next poll, microseconds, if no frame arrives and nothing is requested until
/// then; UINT64_MAX for never.
narx_status_t narx_tx_master_next_poll(struct narx_tx_master_t *master,
                                       uint64_t now,
                                       uint64_t *at);

/// Commands the node, or with `all` not 0 every node of the bus: 1 start, 2 stop, 128 pre-operational, 129
/// reset. Returns NARX_ERROR_FULL while four messages wait for the bus, NARX_ERROR_FIELD for another command.
narx_status_t narx_tx_master_command(struct narx_tx_master_t *master,
                                     uint8_t command,
                                     uint8_t all);

/// Sends a SYNC: every node of the bus samples and sends PDO2. Returns NARX_ERROR_FULL while four messages
/// wait for the bus.
narx_status_t narx_tx_master_sync(struct narx_tx_master_t *master);

/// Asks the node for PDO3. Returns NARX_ERROR_FULL while four messages wait for the bus.
narx_status_t narx_tx_master_ask_positions(struct narx_tx_master_t *master);

/// Requests the value of an entry (NARX_TX_ENTRY_*). Answers come in the order of the requests. Returns
/// NARX_ERROR_FULL while there are eight requests whose answers were not taken.
narx_status_t narx_tx_master_read(struct narx_tx_master_t *master,
                                  uint8_t number);

/// Requests to write an entry (NARX_TX_ENTRY_*). Order and errors are those of narx_tx_master_read.
narx_status_t narx_tx_master_write(struct narx_tx_master_t *master, uint8_t number, uint32_t value);

/// Writes the next answer, or returns NARX_NOTHING.
narx_status_t narx_tx_master_poll_answer(struct narx_tx_master_t *master,
                                         struct narx_tx_answer_t *answer);

/// Writes the state of the node as known at `now`, microseconds.
narx_status_t narx_tx_master_report(struct narx_tx_master_t *master,
                                    uint64_t now,
                                    struct narx_tx_node_report_t *report);

/// Decodes a frame of a bus whose nodes have this layout. Returns NARX_ERROR_NOT_A_MESSAGE if it is no
/// eddyCAN message, or one of another layout; NARX_ERROR_FIELD if a field has an undefined value. Any
/// context; no state.
narx_status_t narx_tx_message_decode(const struct narx_frame_t *frame,
                                     const struct narx_tx_layout_t *layout,
                                     struct narx_tx_message_t *message);

/// Encodes a message as a frame of a bus whose nodes have this layout. Returns NARX_ERROR_NOT_A_MESSAGE if
/// `kind` is no narx_tx_kind_t; NARX_ERROR_FIELD or NARX_ERROR_NODE if a field has an undefined value. Any
/// context; no state.
narx_status_t narx_tx_message_encode(const struct narx_tx_message_t *message,
                                     const struct narx_tx_layout_t *layout,
                                     struct narx_frame_t *frame);

/// Converts a whole number of thousandths (mV, mA, 0.001 degrees) to Q16, rounded to nearest; saturates
/// beyond 32 767 999. Any context.
int32_t narx_q16_from_milli(int32_t milli);

/// Converts a Q16 to thousandths, rounded to nearest; saturates. Any context.
int32_t narx_milli_from_q16(int32_t value);

/// Returns the sum of two Q16, saturating. Any context.
int32_t narx_q16_add(int32_t a, int32_t b);

/// Returns the difference of two Q16, saturating. Any context.
int32_t narx_q16_subtract(int32_t a, int32_t b);

/// Returns the product of two Q16, rounded down, saturating. Any context.
int32_t narx_q16_multiply(int32_t a, int32_t b);

/// Returns the quotient of two Q16, rounded towards 0, saturating; a division by 0 gives the largest or
/// smallest value, or 0 for 0 / 0. Not for a control interrupt: a processor without a 64-bit division takes
/// hundreds of instructions. Any context.
int32_t narx_q16_divide(int32_t a,
                        int32_t b);

/// Converts a Q16 to IQ24, exactly; saturates beyond 127.99999994. Any context.
int32_t narx_iq24_from_q16(int32_t value);

/// Converts an IQ24 to Q16, rounded down. Any context.
int32_t narx_q16_from_iq24(int32_t value);

/// Converts a Q16 to Q15, rounded down; saturates beyond 0.99997. Any context.
int16_t narx_q15_from_q16(int32_t value);

/// Converts a Q15 to Q16, exactly. Any context.
int32_t narx_q16_from_q15(int16_t value);

/// Converts a Q16 to Q12, rounded down; saturates beyond 7.9998. Any context.
int16_t narx_q12_from_q16(int32_t value);

/// Converts a Q12 to Q16, exactly. Any context.
int32_t narx_q16_from_q12(int16_t value);

/// Writes the default configuration, as a start for your own. Its pole pairs are counted.
narx_status_t narx_identification_config_default(struct narx_identification_config_t *config);

/// Returns the bytes that an identification needs on this processor: at most sizeof(narx_identification_t).
/// Any context.
size_t narx_identification_size(void);

/// Makes an identification in `size` bytes of memory: sizeof(narx_identification_t), or
/// narx_identification_size() of your own. It begins with the first step; the drive must then be in Standby,
/// with the shaft at rest. Returns NARX_ERROR_ARGUMENT for a value outside its range.
narx_status_t narx_identification_init(struct narx_identification_t *identification,
                                       size_t size,
                                       const struct narx_identification_config_t *config);

/// Goes on at `now`, microseconds. Call it whenever narx_master_poll_frame has returned NARX_NOTHING; until
/// its end the identification owns the requests, jobs and downloads of the master. Returns NARX_NOTHING
/// before the end and after it; at the end, once, NARX_OK with the figures, or the error. Then the motor
/// stands, and the drive has its former parameters, if it still answers. Errors of the motor and its supply:
/// NARX_ERROR_NO_MOTOR, NARX_ERROR_SHORT, NARX_ERROR_SAGS, NARX_ERROR_UNSTEADY, NARX_ERROR_NO_BACK_EMF,
/// NARX_ERROR_NOT_REACHED, NARX_ERROR_NO_ROOM, NARX_ERROR_COMMISSIONING; of the drive: NARX_ERROR_WRONG_STATE
/// outside Standby, NARX_ERROR_NOT_EQUIPPED without a scope, NARX_ERROR_BOARD for its PWM rate, those of
/// narx_master_poll_job, of an answer and of a download.
narx_status_t narx_identification_step(struct narx_identification_t *identification,
                                       struct narx_master_t *master,
                                       uint64_t now,
                                       struct narx_identified_t *identified);

/// Writes the part that is under way: a narx_identification_stage_t.
narx_status_t narx_identification_stage(struct narx_identification_t *identification,
                                        uint8_t *stage);

/// A mark on the shaft passes the same place as the last time, at `now`, microseconds: while the rotor turns
/// slowly, in the stage Counts, three of these tell the pole pairs. Returns NARX_ERROR_WRONG_STATE, and
/// nothing happens, at any other time.
narx_status_t narx_identification_mark(struct narx_identification_t *identification,
                                       uint64_t now);

/// Stops the motor and restores the parameters, in the steps that follow; the end is NARX_ERROR_ABORTED.
narx_status_t narx_identification_abort(struct narx_identification_t *identification,
                                        struct narx_master_t *master);

/// Writes in words with which error the identification has ended, with its figures; returns NARX_NOTHING if
/// it has ended with none. The text, at most `size` bytes with its closing 0, is cut if it is longer.
narx_status_t narx_identification_error_text(struct narx_identification_t *identification,
                                             char *text,
                                             size_t size);

/// Takes a reading of the slow inputs, about every 10 ms. Temperature and pressure limits act from the first
/// reading on. Background half.
narx_status_t narx_drive_handle_inputs(struct narx_drive_t *drive,
                                       const struct narx_slow_inputs_t *inputs);

/// Takes the state of the CAN controller, as often as the board reads it (parameters 293 to 296). Off the bus
/// no frame is handed out, and frames that wait are dropped; drop those that wait in the controller, too.
/// Background half.
narx_status_t narx_drive_handle_bus_state(struct narx_drive_t *drive,
                                          const struct narx_bus_state_t *state);

/// Writes the levels that the board's lines must have now. Background half.
narx_status_t narx_drive_outputs(struct narx_drive_t *drive, struct narx_outputs_t *outputs);

/// Returns NARX_OK, once, when the master has requested a reboot and the acknowledgement was polled: reset
/// the processor, or call narx_drive_init. Returns NARX_NOTHING otherwise. Background half.
narx_status_t narx_drive_take_reboot(struct narx_drive_t *drive);

/// Writes the default configuration, with the values of Figure 9 of the specification, as a start for your
/// own.
narx_status_t narx_master_config_default(struct narx_master_config_t *config);

/// Returns the bytes that a master needs on this processor: at most sizeof(narx_master_t). Any context.
size_t narx_master_size(void);

/// Makes a master without a command yet in `size` bytes of memory: sizeof(narx_master_t), or
/// narx_master_size() of your own. `config` may be NULL for the default. The master sends set-points of 0,
/// which keep measurements coming, but neither stop a motor nor acknowledge a fault. A drive whose motor
/// another master has started gets none: they would keep the motor turning after that master is gone.
narx_status_t narx_master_init(struct narx_master_t *master,
                               size_t size,
                               const struct narx_master_config_t *config);

/// Takes a frame that arrived at `now`, microseconds. Frames of other nodes are ignored.
narx_status_t narx_master_handle_frame(struct narx_master_t *master,
                                       const struct narx_frame_t *frame,
                                       uint64_t now);

/// Writes the next frame that is due at `now`, microseconds, or returns NARX_NOTHING. Call it until it
/// returns NARX_NOTHING, at the latest at the time of narx_master_next_poll.
narx_status_t narx_master_poll_frame(struct narx_master_t *master,
                                     uint64_t now,
                                     struct narx_frame_t *frame);

/// Writes the latest time of the next poll, microseconds, if no frame arrives and nothing is requested until
/// then; UINT64_MAX for never.
narx_status_t narx_master_next_poll(struct narx_master_t *master,
                                    uint64_t now,
                                    uint64_t *at);

/// Requests a start at a speed, mechanical rpm, negative in reverse, and repeats the request every period. A
/// drive accepts a start only if it received Standby since it last stopped: call narx_master_stop first, or
/// use narx_master_begin, which does so and reports the result. Returns NARX_ERROR_SPEED for a speed outside
/// the limits of narx_master_speed_limits, or, before these were received, outside the range of MOTOR_CMD.
/// Open loop runs at parameter 88, whatever speed is requested. `accepted_speed` of narx_master_report is the
/// speed that the drive uses.
narx_status_t narx_master_start(struct narx_master_t *master,
                                int32_t rpm);

/// Requests another speed in the same direction, rpm. Returns NARX_ERROR_SPEED as narx_master_start does.
narx_status_t narx_master_set_speed(struct narx_master_t *master,
                                    uint16_t rpm);

/// Writes the limits of the set-point in the mode that the drive's parameters enable. Returns NARX_NOTHING
/// before those parameters were received (78, 81 to 83, and those of narx_speed_limits_t); `read_parameters`
/// of narx_master_config_t makes the master read them.
narx_status_t narx_master_speed_limits(struct narx_master_t *master,
                                       struct narx_speed_limits_t *limits);

/// Requests Standby, which also acknowledges a fault.
narx_status_t narx_master_stop(struct narx_master_t *master);

/// Requests a shutdown (motor mode 3): fault bit 28.
narx_status_t narx_master_shut_down(struct narx_master_t *master);

/// Writes the state of the drive as known at `now`, microseconds.
narx_status_t narx_master_report(struct narx_master_t *master,
                                 uint64_t now,
                                 struct narx_drive_report_t *report);

/// Writes the last measurement frame of one kind, NARX_MESSAGE_MEASUREMENT_0 to _8, as a message, and the
/// time of its reception (microseconds; `at` may be NULL). Returns NARX_NOTHING before the first.
narx_status_t narx_master_measurement(struct narx_master_t *master,
                                      uint16_t kind,
                                      struct narx_message_t *message,
                                      uint64_t *at);

/// Writes the value of a parameter as last received, raw, and the time of its reception (microseconds; `at`
/// may be NULL). Returns NARX_NOTHING while it was not received. It sends nothing on the bus; to read a
/// parameter anew use NARX_REQUEST_KIND_READ.
narx_status_t narx_master_parameter(struct narx_master_t *master,
                                    uint16_t number,
                                    int32_t *value,
                                    uint64_t *at);

/// Begins a download: a narx_download_kind_t with its arguments, 0 for those that it does not need. Returns
/// NARX_ERROR_FULL while there is another whose result was not taken, NARX_ERROR_SILENT for a silent master,
/// NARX_ERROR_REQUEST for an undefined kind.
narx_status_t narx_master_download(struct narx_master_t *master,
                                   uint8_t kind,
                                   uint32_t first,
                                   uint32_t count);

/// Writes the next words of the download, or returns NARX_NOTHING. Words may come more than once, each time
/// the same.
narx_status_t narx_master_poll_chunk(struct narx_master_t *master,
                                     struct narx_chunk_t *chunk);

/// Returns the result of the download, once all its chunks were taken: NARX_OK, with its length in words,
/// NARX_NOTHING before the end, or the error: NARX_ERROR_NO_ANSWER, NARX_ERROR_NO_LOG, NARX_ERROR_SPOILED,
/// NARX_ERROR_ABORTED, or the reason of the drive's refusal.
narx_status_t narx_master_poll_download(struct narx_master_t *master,
                                        uint32_t *words);

/// Aborts the download; its result is NARX_ERROR_ABORTED.
narx_status_t narx_master_abort_download(struct narx_master_t *master);

/// Begins a job of the motor: a narx_job_kind_t, and for a start its speed, mechanical rpm, negative in
/// reverse. One that is under way ends without a result; narx_master_start, narx_master_stop and
/// narx_master_shut_down end one, too. Returns NARX_ERROR_SILENT for a silent master, NARX_ERROR_SPEED as
/// narx_master_start does, and NARX_ERROR_REQUEST for another kind.
narx_status_t narx_master_begin(struct narx_master_t *master,
                                uint8_t kind,
                                int32_t rpm);

/// Begins a job of the scope or the log: a narx_job_kind_t, its settings (which may be NULL where it arms
/// nothing), and the longest wait for a record, microseconds. One that is under way ends without a result;
/// jobs of the motor go on. Returns NARX_ERROR_SILENT for a silent master, and NARX_ERROR_REQUEST for another
/// kind.
narx_status_t narx_master_begin_record(struct narx_master_t *master,
                                       uint8_t kind,
                                       const struct narx_scope_setup_t *setup,
                                       uint64_t within);

/// Returns the result of the motor's job: NARX_OK, NARX_NOTHING before its end, or the error, with its
/// details in `failure` (which may be NULL): NARX_ERROR_FAULT, NARX_ERROR_START_REFUSED,
/// NARX_ERROR_TIMED_OUT, NARX_ERROR_NOT_CALIBRATED, NARX_ERROR_ABORTED, NARX_ERROR_NO_ANSWER,
/// NARX_ERROR_NOT_OBEYED, or the reason of the drive's refusal of a parameter.
narx_status_t narx_master_poll_job(struct narx_master_t *master,
                                   struct narx_job_failure_t *failure);

/// Returns the result of the job of the scope or the log, as narx_master_poll_job does. Its own errors:
/// NARX_ERROR_OUT_OF_RANGE for a setting (`parameter`), NARX_ERROR_SCOPE_REFUSED (`refusal`, or `scope` where
/// its state forbids the job), NARX_ERROR_NOT_EQUIPPED without a memory, NARX_ERROR_TIMED_OUT for a record
/// that was not complete in time (`scope`).
narx_status_t narx_master_poll_record(struct narx_master_t *master,
                                      struct narx_job_failure_t *failure);

/// Ends the job of the scope or the log; its result is NARX_ERROR_ABORTED. What the drive has begun goes on.
narx_status_t narx_master_abort_record(struct narx_master_t *master);

/// Queues a request to the drive. Answers come in the order of the requests. Returns NARX_ERROR_FULL while
/// there are eight requests whose answers were not taken, NARX_ERROR_SILENT for a silent master,
/// NARX_ERROR_REQUEST for an undefined kind or number.
narx_status_t narx_master_request(struct narx_master_t *master,
                                  const struct narx_request_t *request);

/// Writes the next answer, or returns NARX_NOTHING.
narx_status_t narx_master_poll_answer(struct narx_master_t *master, struct narx_answer_t *answer);

/// Decodes a frame. Returns NARX_ERROR_NOT_A_MESSAGE if it is none of narx_message_kind_t, or not well
/// formed; NARX_ERROR_FIELD if a field has an undefined value. The priority in the identifier is ignored. Any
/// context; no state.
narx_status_t narx_message_decode(const struct narx_frame_t *frame,
                                  struct narx_message_t *message);

/// Encodes a message as a frame. Returns NARX_ERROR_NOT_A_MESSAGE if `kind` is no narx_message_kind_t;
/// NARX_ERROR_FIELD if a field has an undefined value or one that does not fit in its bits. Any context; no
/// state.
narx_status_t narx_message_encode(const struct narx_message_t *message,
                                  struct narx_frame_t *frame);

/// Makes a control at power-up, in Initialization, in `size` bytes of memory. `coefficients` are those that
/// `narx coefficients` has printed, or narx_coefficients_build has built. They are copied, and not checked.
narx_status_t narx_motor_init(struct narx_motor_t *motor,
                              size_t size,
                              const struct narx_coefficients_t *coefficients);

/// Runs one control tick: takes the samples of this period and writes the command to apply. Call it from the
/// control interrupt, once a PWM period.
///
/// On an error the command, if `command` is a valid pointer, is coast at duty 0: a caller that ignores the
/// status still turns the bridge off.
narx_status_t narx_motor_step(struct narx_motor_t *motor,
                              const struct narx_samples_t *samples,
                              struct narx_pwm_command_t *command);

/// Takes a command: `mode` is 0 Standby, 1 Drive, 2 Reverse, 3 Shutdown, `speed` the magnitude of the
/// electrical set-point, Q16 rev/s: rpm x pole pairs / 60 x 65 536. It restarts the command time-out, so
/// repeat it. Standby acknowledges a fault; Drive and Reverse start the motor if Standby was requested
/// before.
narx_status_t narx_motor_handle_command(struct narx_motor_t *motor,
                                        uint8_t mode,
                                        int32_t speed);

/// Takes a set-point alone, Q16 rev/s as in narx_motor_handle_command: the request stays. It restarts the
/// command time-out, too.
narx_status_t narx_motor_handle_set_point(struct narx_motor_t *motor,
                                          int32_t speed);

/// Takes a temperature, Q16 degrees Celsius, and a pressure reading, Q16 V, about every 10 ms. Their limits
/// act from the first reading on.
narx_status_t narx_motor_handle_inputs(struct narx_motor_t *motor,
                                       int32_t temperature,
                                       int32_t pressure);

/// Takes other coefficients, in any state: they hold from the next tick on.
narx_status_t narx_motor_change_coefficients(struct narx_motor_t *motor,
                                             const struct narx_coefficients_t *coefficients);

/// The next start finds the wiring of the hall sensors instead of running the motor (`run` is not 0), or runs
/// it again (0). narx_motor_report_t shows the result.
narx_status_t narx_motor_calibrate_hall(struct narx_motor_t *motor,
                                        uint8_t run);

/// Builds coefficients from parameters: the factory's, and `count` others, raw with the units and scales of
/// PROTOCOL.md. `stored` may be NULL if `count` is 0, `board` for the default board. Parameters that do not
/// fit each other give NARX_ERROR_PARAMETERS; `error`, which may be NULL, then names one. Not for an
/// interrupt: it divides.
///
/// It takes 11 KB of flash, or 30 in a library with the texts of the parameters. Where the parameters are
/// known when the program is built, let `narx coefficients` print what this would build.
narx_status_t narx_coefficients_build(struct narx_coefficients_t *coefficients,
                                      const struct narx_board_t *board,
                                      const struct narx_stored_t *stored,
                                      size_t count,
                                      struct narx_parameter_error_t *error);

/// Writes the report of the last step if one is due, or returns NARX_NOTHING: one is due every millisecond,
/// and when the state or the faults change.
narx_status_t narx_motor_poll_report(struct narx_motor_t *motor,
                                     struct narx_motor_report_t *report);

/// Runs a drive from a recording's initial state through all of its ticks. `bytes` is the recording, `length`
/// bytes.
///
/// The drive is on the stack. Any context.
narx_status_t narx_replay(const uint8_t *bytes,
                          size_t length,
                          struct narx_outcome_t *outcome);

/// Runs the first `ticks` ticks of a recording, or all of a shorter one, as narx_replay does;
/// `recorded_digest` is then 0. Writes all outputs of the last tick in one line into `text`, which has
/// `text_size` bytes: NARX_OUTPUTS_TEXT_SIZE are enough. A longer text is cut; a closing 0 ends it. The line
/// is empty if no tick was run. If the recording cannot be replayed, the line holds the reason and the place.
///
/// `text` may be NULL if `text_size` is 0.
narx_status_t narx_replay_until(const uint8_t *bytes,
                                size_t length,
                                uint64_t ticks,
                                struct narx_outcome_t *outcome,
                                char *text,
                                size_t text_size);

/// Powers up a drive's node, or a TX-Driver, as described in a transcript, and makes the first `calls` calls
/// of the transcript, or all of a shorter one (UINT64_MAX: all). `bytes` is the transcript, `length` bytes.
/// In the outcome `ticks` counts calls, and `recorded_digest` is 0 unless all calls were requested.
///
/// The device is on the stack. Any context.
narx_status_t narx_replay_transcript(const uint8_t *bytes,
                                     size_t length,
                                     uint64_t calls,
                                     struct narx_outcome_t *outcome);

/// Returns the bytes that a scope with room for `samples` needs on this processor. Any context.
size_t narx_scope_size(uint16_t samples);

/// Gives the drive's virtual scope its memory of `size` bytes: sizeof(narx_scope_t), or narx_scope_size() of
/// memory of your own that is aligned like a narx_scope_t. Returns NARX_ERROR_SIZE if it has no room for one
/// sample. Without memory the scope cannot be armed. Call it after narx_drive_init and before the first
/// narx_drive_step; narx_drive_init detaches the memory again.
narx_status_t narx_drive_attach_scope(struct narx_drive_t *drive,
                                      struct narx_scope_t *memory,
                                      size_t size);

/// Returns the version of the library, "major.minor.patch": a constant string.
const char *narx_version(void);

/// Returns a status in words, for a log: a constant string, never NULL, whatever the number.
const char *narx_status_text(int32_t status);

/// Returns the bytes that a storage needs on this processor: at most sizeof(narx_storage_t). Any context.
size_t narx_storage_size(void);

/// Makes a storage in `size` bytes of memory. `flash` is copied. Its functions, none of which may be NULL,
/// are called only within narx_storage_init_drive and narx_storage_serve.
narx_status_t narx_storage_init(struct narx_storage_t *storage,
                                size_t size,
                                const struct narx_flash_t *flash);

/// Makes a drive as narx_drive_init does, with the parameters that the flash holds, or factory values for
/// those that it does not hold. The drive then keeps its parameters and its log on this flash. The drive
/// reports the state of the flash on the bus, including fault bits 26, 30 and 31. `identity` may be NULL.
narx_status_t narx_storage_init_drive(struct narx_storage_t *storage,
                                      struct narx_drive_t *drive,
                                      size_t size,
                                      const struct narx_board_t *board,
                                      const struct narx_identity_t *identity);

/// Runs one bounded step of the drive's work on its flash: a store, a record of the log, a piece of an erase.
/// Returns NARX_NOTHING if there is none. Call it in every pass of the main loop. It takes as long as your
/// flash does, and some 6 KiB of stack. Background half.
narx_status_t narx_storage_serve(struct narx_storage_t *storage,
                                 struct narx_drive_t *drive);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif // NARX_H
