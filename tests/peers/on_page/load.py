"""What the page costs while samples come."""

import os
import pathlib
import time

from on_page.tab import Floor, Tab


def under_load(browser, folder):
    """The page over 12 000 samples a second: what daemon and browser take. Printed, not judged: it is the computer's speed too."""
    seconds = 15
    with Floor(folder, 4) as floor:
        time.sleep(8)
        began = cpu_s([floor.service.pid])
        time.sleep(seconds)
        alone = (cpu_s([floor.service.pid]) - began) / seconds
        tab = Tab(browser, floor.address)
        received = [0]
        session = tab.context.new_cdp_session(tab.page)
        session.send("Network.enable")
        session.on("Network.dataReceived", lambda event: received.__setitem__(0, received[0] + event["dataLength"]))
        tab.view("measure")
        tab.until("document.querySelectorAll('[role=meter]').length === 3")
        tab.page.evaluate("() => { window.frames_seen = 0; const count = () => { window.frames_seen += 1; requestAnimationFrame(count); }; count(); }")
        browser_pids = of_browser()
        service_s, browser_s, bytes_before = cpu_s([floor.service.pid]), cpu_s(browser_pids), received[0]
        frames_before = tab.page.evaluate("window.frames_seen")
        tab.page.wait_for_timeout(1000 * seconds)
        frames = (tab.page.evaluate("window.frames_seen") - frames_before) / seconds
        watched = (cpu_s([floor.service.pid]) - service_s) / seconds
        figures = {
            "service, nobody watches": f"{100 * alone:.0f} % of a processor",
            "service, one browser on *Measure*": f"{100 * watched:.0f} % of a processor",
            "browser, with a counter of frames in the page": f"{100 * (cpu_s(browser_pids) - browser_s) / seconds:.0f} % of a processor",
            "frames a second": f"{frames:.0f}",
            "bytes a second to the browser": f"{(received[0] - bytes_before) / seconds:.0f}",
        }
        for name, figure in figures.items():
            print(f"load  {name}: {figure}", flush=True)
        tab.close()


def cpu_s(processes):
    """Processor time of processes so far, s."""
    ticks = 0
    for process in processes:
        try:
            fields = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
            ticks += int(fields[11]) + int(fields[12])
        except FileNotFoundError:
            pass
    return ticks / os.sysconf("SC_CLK_TCK")


def of_browser():
    running = [int(one.name) for one in pathlib.Path("/proc").iterdir() if one.name.isdigit()]
    named = lambda process: (pathlib.Path(f"/proc/{process}/comm").read_text().startswith("chromium"))
    ours = []
    for process in running:
        try:
            if named(process):
                ours.append(process)
        except (FileNotFoundError, ProcessLookupError):
            pass
    return ours
