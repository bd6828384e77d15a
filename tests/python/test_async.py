"""A drive for asyncio."""

import asyncio
from typing import Any

import can
import pytest

import narx

VIRTUAL: dict[str, Any] = {"interface": "narx", "motor": "ec45-flat-50w-18v", "supply_voltage": 18.0, "mode": "hall"}


@pytest.mark.parametrize("realtime", [True, False])
def test_the_same_names_are_awaited(realtime: bool, request: pytest.FixtureRequest) -> None:
    async def main() -> None:
        async with narx.connect_async(channel=request.node.name, realtime=realtime, **VIRTUAL) as drive:
            assert drive.state is narx.State.STANDBY and "narx.AsyncDrive in Standby" in repr(drive)
            await drive.start(1500)
            assert await drive.wait_for(lambda: abs((drive.measurements.speed or 0) - 1500) < 30, 5.0)
            await drive.set_speed(1600)
            assert (await drive.info).address == 170 and await drive.diagnostics is not None
            limit = await drive.parameters["Phase current limit"]
            await drive.parameters.set("Phase current limit", limit - 0.5)
            assert await drive.parameters["Phase current limit"] == pytest.approx(limit - 0.5)
            assert await drive.log.capacity > 0
            with pytest.raises(narx.ParameterError, match='there is no parameter "Phase curent limit"'):
                await drive.parameters["Phase curent limit"]
            with pytest.raises(AttributeError, match="Drive has no strat"):
                await drive.strat(1)
            assert "start" in dir(drive)
            await drive.stop()
            assert await drive.wait_for(lambda: drive.state is narx.State.STANDBY)

    asyncio.run(main())


def test_tasks_run_while_one_waits_and_requests_take_turns(request: pytest.FixtureRequest) -> None:
    async def main() -> None:
        async with narx.connect_async(channel=request.node.name, **VIRTUAL) as drive:
            order: list[str] = []

            async def read(name: str) -> float:
                value = await drive.parameters[name]
                order.append(name)
                return float(value)

            async def wait() -> None:
                await drive.wait(0.5)
                order.append("waited")

            names = ["Motor pair poles", "Phase current limit", "Nominal supply voltage"]
            _, *values = await asyncio.gather(wait(), *(read(name) for name in names))
            assert values[0] == 8 and values[2] == 18 and order == [*names, "waited"]

    asyncio.run(main())


def test_a_cancelled_call_ends_and_stop_takes_the_start_back(request: pytest.FixtureRequest) -> None:
    async def main() -> None:
        async with narx.connect_async(channel=request.node.name, **VIRTUAL) as drive:
            waiting = asyncio.create_task(drive.wait(3600))
            await asyncio.sleep(0.05)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.05):
                    await drive.wait_for(lambda: False, 3600)
            # The drive is free for the next request, in whatever thread it is made.
            for _ in range(10):
                assert await asyncio.to_thread(drive._drive.parameters.__getitem__, "Motor pair poles") == 8
                assert await drive.parameters["Motor pair poles"] == 8

    asyncio.run(main())


def test_messages_arrive_as_they_come(request: pytest.FixtureRequest) -> None:
    async def main() -> None:
        async with narx.connect_async(channel=request.node.name, **VIRTUAL) as drive:
            seen: set[str] = set()
            async for message in drive.messages():
                seen.add(message.name)
                if {"STATUS_WORD", "MEASUREMENT_2"} <= seen:
                    break
        async with narx.connect_async(channel=f"{request.node.name} stepped", realtime=False, **VIRTUAL) as drive:
            with pytest.raises(narx.RefusedError, match="realtime=False"):
                await anext(drive.messages())

    asyncio.run(main())


def test_the_motor_is_stopped_at_the_end_and_after_an_error(request: pytest.FixtureRequest) -> None:
    async def main(channel: str) -> None:
        async with narx.connect_async(channel=channel, realtime=False, **VIRTUAL) as drive:
            await drive.start(1500)
            raise RuntimeError("of the test")

    with can.Bus(channel=request.node.name, realtime=False, **VIRTUAL) as bus:
        with pytest.raises(RuntimeError, match="of the test"):
            asyncio.run(main(request.node.name))
        with narx.Drive(bus, silent=True) as watching:
            watching.wait(0.2)
            assert watching.measurements.speed is not None and abs(watching.measurements.speed) < 1500
            watching.wait(2.0)
            assert watching.measurements.speed == 0
    with pytest.raises(narx.ParameterError, match="there is no interface"):
        asyncio.run(narx.connect_async("nothing").__aenter__())
