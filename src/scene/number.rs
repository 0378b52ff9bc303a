//! Numbers in messages.

use std::f64::consts::PI;

/// Formats a number with four significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = (3.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        let text = format!("{value:.3e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
    }
}

/// Formats a speed, given in rad/s, as rad/s and as rpm.
pub fn with_rpm(speed: f64) -> String {
    format!("{} rad/s ({} rpm)", short(speed), short(rpm(speed)))
}

/// Formats a range of speeds, given in rad/s, as rad/s and as rpm.
pub fn range_with_rpm([low, high]: [f64; 2]) -> String {
    format!("{} to {} rad/s ({} to {} rpm)", short(low), short(high), short(rpm(low)), short(rpm(high)))
}

fn rpm(speed: f64) -> f64 {
    speed * 30.0 / PI
}

/// Says that a table with a `range` does not contain the speed `own` of a shaft, both in rad/s, and what to do.
pub fn outside_table(range: [f64; 2], shaft: &str, own: f64) -> String {
    let at_rest = if own == 0.0 { "give a speed of the table with speed=..., " } else { "" };
    format!(
        "the table ranges from {}, but {shaft} turns at {}; {at_rest}extend the table, or hold its end values with outside=\"hold\"",
        range_with_rpm(range),
        with_rpm(own)
    )
}

/// Says that a table with a `range` does not contain the frequency of a vibration, both in rad/s, and what to do.
pub fn outside_frequencies([first, last]: [f64; 2], frequency: f64) -> String {
    format!(
        "the table has the frequencies {} to {} rad/s, but the vibration has {} rad/s; extend the table, ask for fewer modes or frequencies, or hold its end values with outside=\"hold\"",
        short(first),
        short(last),
        short(frequency.abs())
    )
}
