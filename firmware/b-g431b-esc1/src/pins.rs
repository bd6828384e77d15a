//! The pins: one table, from which come the words of the ports' registers. Sources: docs/B-G431B-ESC1.md.

use Function::{Alternate, Analog, Input, Output};
use Port::{A, B, C};
use Pull::{Down, None as Free, Up};

/// A port with pins of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// GPIOA.
    A,
    /// GPIOB.
    B,
    /// GPIOC.
    C,
}

/// Use of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// To or from an analogue part.
    Analog,
    /// A peripheral's, by the number of the alternate function.
    Alternate(u8),
    /// Read by us.
    Input,
    /// Driven by us, at first with this level.
    Output(bool),
}

/// Resistor inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pull {
    /// None.
    None,
    /// To the supply.
    Up,
    /// To ground.
    Down,
}

/// A pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Port.
    pub port: Port,
    /// 0 to 15.
    pub number: u8,
    /// Its use.
    pub function: Function,
    /// Resistor inside.
    pub pull: Pull,
    /// Its name on the board.
    pub name: &'static str,
}

const fn pin(port: Port, number: u8, function: Function, pull: Pull, name: &'static str) -> Pin {
    Pin { port, number, function, pull, name }
}

/// Every pin that is used.
pub const PINS: [Pin; 37] = [
    pin(A, 8, Alternate(6), Down, "TIM1_CH1, phase A high"),
    pin(C, 13, Alternate(4), Down, "TIM1_CH1N, phase A low"),
    pin(A, 9, Alternate(6), Down, "TIM1_CH2, phase B high"),
    pin(A, 12, Alternate(6), Down, "TIM1_CH2N, phase B low"),
    pin(A, 10, Alternate(6), Down, "TIM1_CH3, phase C high"),
    pin(B, 15, Alternate(4), Down, "TIM1_CH3N, phase C low"),
    pin(A, 0, Analog, Free, "ADC1_IN1, bus voltage"),
    pin(A, 4, Analog, Free, "ADC2_IN17, terminal of phase A"),
    pin(C, 4, Analog, Free, "ADC2_IN5, terminal of phase B"),
    pin(B, 11, Analog, Free, "ADC2_IN14, terminal of phase C"),
    pin(B, 5, Output(false), Free, "GPIO_BEMF, dividers of the terminals on when low"),
    pin(A, 1, Analog, Free, "OPAMP1_VINP and COMP1_INP, shunt of phase A"),
    pin(A, 3, Analog, Free, "OPAMP1_VINM"),
    pin(A, 2, Analog, Free, "OPAMP1_VOUT and ADC1_IN3"),
    pin(A, 7, Analog, Free, "OPAMP2_VINP and COMP2_INP, shunt of phase B"),
    pin(A, 5, Analog, Free, "OPAMP2_VINM"),
    pin(A, 6, Analog, Free, "OPAMP2_VOUT and ADC2_IN3"),
    pin(B, 0, Analog, Free, "OPAMP3_VINP and COMP4_INP, shunt of phase C"),
    pin(B, 2, Analog, Free, "OPAMP3_VINM"),
    pin(B, 1, Analog, Free, "OPAMP3_VOUT and ADC1_IN12"),
    pin(B, 14, Analog, Free, "ADC1_IN5, thermistor"),
    pin(B, 12, Analog, Free, "ADC1_IN11, potentiometer"),
    pin(B, 6, Alternate(2), Up, "TIM4_CH1, hall A"),
    pin(B, 7, Alternate(2), Up, "TIM4_CH2, hall B"),
    pin(B, 8, Alternate(2), Up, "TIM4_CH3, hall C"),
    pin(A, 11, Alternate(9), Up, "FDCAN1_RX"),
    pin(B, 9, Alternate(9), Free, "FDCAN1_TX"),
    pin(C, 11, Output(false), Free, "CAN_SHDN, transceiver on when low"),
    pin(C, 14, Output(true), Free, "CAN_TERM, 120 ohm on when high"),
    pin(A, 15, Input, Down, "PWM input of J3, DSIO1"),
    pin(C, 10, Input, Up, "button, low when pressed, DSIO2"),
    pin(C, 6, Output(false), Free, "status LED"),
    pin(A, 13, Alternate(0), Up, "SWDIO"),
    pin(A, 14, Alternate(0), Down, "SWCLK"),
    // The lines of the virtual serial port are nobody's.
    pin(B, 3, Analog, Free, "USART2_TX of J3 and ST-LINK"),
    pin(B, 4, Analog, Free, "USART2_RX of J3 and ST-LINK"),
    pin(B, 10, Analog, Free, "not connected"),
];

/// The words of a port's registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// MODER.
    pub mode: u32,
    /// OSPEEDR.
    pub speed: u32,
    /// PUPDR.
    pub pull: u32,
    /// AFRL and AFRH.
    pub alternate: [u32; 2],
    /// ODR.
    pub output: u32,
}

/// The words of `port`; pins that nobody uses are analogue, which costs no current.
pub const fn words(port: Port) -> Words {
    let mut words = Words { mode: u32::MAX, speed: 0, pull: 0, alternate: [0; 2], output: 0 };
    let mut index = 0;
    while index < PINS.len() {
        let pin = PINS[index];
        index += 1;
        if pin.port as u8 != port as u8 {
            continue;
        }
        let place = 2 * pin.number as u32;
        let mode = match pin.function {
            Input => 0b00,
            Output(_) => 0b01,
            Alternate(_) => 0b10,
            Analog => 0b11,
        };
        words.mode &= !((mode ^ 0b11) << place);
        words.pull |= (match pin.pull {
            Free => 0b00,
            Up => 0b01,
            Down => 0b10,
        }) << place;
        if let Alternate(function) = pin.function {
            // High speed: 5 ns edges, which dead time and CAN are made for.
            words.speed |= 0b10 << place;
            words.alternate[pin.number as usize / 8] |= (function as u32) << (4 * (pin.number as u32 % 8));
        }
        if let Output(true) = pin.function {
            words.output |= 1 << pin.number;
        }
    }
    words
}
