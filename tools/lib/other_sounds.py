"""Sounds that are no ring of one body: noises, loops, voices, music, sweeps. Each generator takes a sounds.Maker."""
import math

import sounds

SAMPLES = "/usr/share/sonic-pi/samples/"  # Debian's sonic-pi-samples (CC0)
RECORDED = ["loop_amen", "loop_breakbeat", "loop_compus", "loop_tabla", "loop_industrial", "loop_mika", "misc_crow", "vinyl_hiss",
            "vinyl_scratch", "ambi_choir", "ambi_lunar_land", "ambi_swoosh"]


def looped(maker, piece, seconds):
    return (piece * (int(seconds * maker.rate_hz / len(piece)) + 1))[:int(seconds * maker.rate_hz)]


def applause(maker, seconds=3.0, per_s=400):
    """Claps of many hands: bursts of noise of 5 ms at random times and levels."""
    out, clap = maker.noise(seconds), maker.noise(0.03)
    out = [1e-3 * x for x in out]
    for _ in range(int(per_s * seconds)):
        decay = maker.random.uniform(150, 500) / maker.rate_hz
        burst = [x * math.exp(-decay * i) for i, x in enumerate(clap)]
        sounds.added(out, burst, maker.random.randrange(len(out)), 10 ** (-maker.random.uniform(0, 30) / 20))
    return out


def voice(maker, seconds=3.0, base_hz=120.0):
    """Syllables: pulses of a gliding pitch through three gliding formants, pauses between."""
    rate, out, at = maker.rate_hz, [], 0.0
    while at < seconds:
        length, pause = maker.random.uniform(0.12, 0.35), maker.random.uniform(0.02, 0.12)
        pitch, glide = base_hz * maker.random.uniform(0.8, 1.4), maker.random.uniform(-0.4, 0.3)
        formants = [maker.random.uniform(*r) for r in ((300, 900), (900, 2300), (2300, 3200))]
        state, phase = [[0.0, 0.0] for _ in formants], 0.0
        for i in range(int(length * rate)):
            u = i / (length * rate)
            phase += pitch * (1 + glide * u) / rate
            pulse = 1.0 if phase >= 1 else 0.02 * maker.random.gauss(0, 1)
            phase %= 1.0
            sample = 0.0
            for s, f in zip(state, formants):
                width = math.exp(-math.pi * 90 / rate)
                s[0], s[1] = 2 * width * math.cos(2 * math.pi * f * (1 + 0.1 * u) / rate) * s[0] - width * width * s[1] + pulse, s[0]
                sample += s[0] - s[1]
            out.append(sample * math.sin(math.pi * u) ** 0.5)
        out += [0.0] * int(pause * rate)
        at += length + pause
    return sounds.added(out, maker.noise(len(out) / rate), 0, 0.003)


def music(maker, seconds=4.0, vibrato=0.008, voices=3):
    """Notes of a bowed string, one after another: eight harmonics, vibrato, swelling."""
    out = [0.0] * int(seconds * maker.rate_hz)
    for _ in range(voices):
        at = 0.0
        while at < seconds:
            length, pitch = maker.random.uniform(0.25, 0.7), 220 * 2 ** (maker.random.randrange(24) / 12)
            rate = maker.random.uniform(4.5, 6.5)
            for k in range(1, 9):
                tone = maker.glide(length, lambda t: k * pitch * (1 + vibrato * math.sin(2 * math.pi * rate * t)),
                                   lambda t: math.sin(math.pi * t / length) ** 0.7 / k)
                sounds.added(out, tone, int(at * maker.rate_hz))
            at += length
    return sounds.added(out, maker.noise(seconds), 0, 0.003)


def modulated(maker, slope, low_hz, high_hz, seconds=3.0):
    """Noise whose level wanders at random between the rates (wind, surf, breath)."""
    level, out, value = maker.noise(seconds, 2), maker.noise(seconds, slope), 0.0
    keep = math.exp(-2 * math.pi * high_hz / maker.rate_hz)
    for i, x in enumerate(level):
        value = keep * value + (1 - keep) * x
        out[i] *= math.exp(2 * value) * (1 + 0.5 * math.sin(2 * math.pi * low_hz * i / maker.rate_hz))
    return out


def sweep(maker, start_hz, end_hz, seconds=2.0, logarithmic=True):
    ratio = end_hz / start_hz
    tone = maker.glide(seconds, lambda t: start_hz * ratio ** (t / seconds) if logarithmic else start_hz + (end_hz - start_hz) * t / seconds,
                       lambda t: 1.0)
    return sounds.added(tone, maker.noise(seconds), 0, 1e-3)


def siren(maker):
    tone = maker.glide(3.0, lambda t: 700 + 250 * math.sin(2 * math.pi * 1.5 * t), lambda t: 1.0)
    return sounds.added(tone, maker.noise(3.0), 0, 0.01)


def engine(maker):
    """Pulses of an uneven running motor."""
    out, at = [0.02 * x for x in maker.noise(3.0, 1)], 0.0
    while at < 3.0:
        sounds.added(out, [x * math.exp(-i / (0.006 * maker.rate_hz)) for i, x in enumerate(maker.noise(0.03, 1))], int(at * maker.rate_hz))
        at += maker.random.gauss(1 / 28, 0.002)
    return out


def clicks(maker):
    out = [1e-3 * x for x in maker.noise(3.0)]
    for _ in range(60):
        sounds.added(out, [1.0, -0.7, 0.3], maker.random.randrange(len(out)))
    return out


def drums(maker):
    """Two bars of synthetic kick, snare and hat, looped."""
    out = [0.0] * int(4.0 * maker.rate_hz)
    for k in range(32):
        at = int(0.125 * k * maker.rate_hz)
        hat = [x * math.exp(-i / (0.01 * maker.rate_hz)) for i, x in enumerate(maker.noise(0.05, -2))]
        sounds.added(out, hat, at, 0.2)
        if k % 8 == 4:
            sounds.added(out, [x * math.exp(-i / (0.04 * maker.rate_hz)) for i, x in enumerate(maker.noise(0.2))], at, 0.5)
        if k % 4 == 0 and k % 8 == 0:
            sounds.added(out, maker.glide(0.3, lambda t: 50 + 120 * math.exp(-30 * t), lambda t: math.exp(-12 * t)), at)
    return out


def generated():
    """(name, function of a Maker)."""
    return [("white", lambda m: m.noise(2.0)), ("pink", lambda m: m.noise(2.0, 1)), ("brown", lambda m: m.noise(2.0, 2)),
            ("white loop 0.5 s", lambda m: looped(m, m.noise(0.5), 3.0)), ("white loop 0.1 s", lambda m: looped(m, m.noise(0.1), 3.0)),
            ("brown loop 0.5 s", lambda m: looped(m, m.noise(0.5, 2), 3.0)), ("pink loop 1 s", lambda m: looped(m, m.noise(1.0, 1), 3.0)),
            ("applause", applause), ("applause loop", lambda m: looped(m, applause(m, 0.7), 3.0)), ("speech low", voice),
            ("speech high", lambda m: voice(m, base_hz=220.0)), ("strings", music), ("wind", lambda m: modulated(m, 1, 0.3, 2.0)),
            ("sweep", lambda m: sweep(m, 100, 8000)), ("siren", siren), ("engine", engine), ("clicks", clicks), ("drum loop", drums),
            ("surf", lambda m: modulated(m, 2, 0.5, 5.0)), ("crowd", lambda m: sounds.added(voice(m), voice(m, base_hz=180.0))),
            ("blue", lambda m: m.noise(2.0, -2)), ("falling sweep", lambda m: sweep(m, 3000, 200, 1.0, False))]
