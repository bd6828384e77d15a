// Commands a drive behind an slcan adapter on a TCP port: node drive.mjs HOST:PORT RPM SECONDS

import { connect } from "node:net";
import process from "node:process";
import loadCore, { SlcanLines, closeSlcan, encodeSlcan, openSlcan } from "narx/core";
import { Drive } from "narx/drive";

const [address = "127.0.0.1:2000", rpm = "2000", seconds = "5"] = process.argv.slice(2);
const [host, port] = address.split(":");

await loadCore();
const drive = new Drive();
const lines = new SlcanLines();
const now = () => performance.now() / 1000;

// The drive has no clock and no bus of its own: frames go in, frames come out, and often enough.
const socket = connect({ host, port: Number(port), noDelay: true });
await new Promise((connected, failed) => socket.once("connect", connected).once("error", failed));
socket.on("data", (bytes) => lines.handleBytes(bytes).forEach((frame) => drive.handleFrame(frame, now())));
socket.write(openSlcan(500_000));
const clock = setInterval(() => drive.poll(now()).forEach((frame) => socket.write(encodeSlcan(frame))), 5);

try {
    await drive.start(Number(rpm));
    for (let second = 0; second < Number(seconds); second++) {
        await drive.wait(1);
        console.log(`${drive.stateName}: ${drive.speed} rpm, ${drive.measurement("HV Voltage")?.toFixed(1)} V`);
    }
    console.log(`${await drive.parameters.get("Motor pair poles")} pole pairs, faults: ${drive.faults.join(", ") || "none"}`);
} catch (error) {
    console.error(`${error.name}: ${error.message}`);
    process.exitCode = 1;
} finally {
    // Standby goes out before the bus is left.
    drive.stop();
    await drive.wait(0.5);
    clearInterval(clock);
    socket.end(closeSlcan());
}
