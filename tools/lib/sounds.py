"""Sounds as lists of numbers: files by libsndfile, rates by libsamplerate, spectra by FFTW, rings and noises with a seed.

What tools/identify-bars and tools/bubble-bars make their recordings from; standard library only, the C libraries by ctypes.
"""
import array
import ctypes
import itertools
import math
import operator
import pathlib

_sndfile = ctypes.CDLL("libsndfile.so.1")
_samplerate = ctypes.CDLL("libsamplerate.so.0")
_fftw = ctypes.CDLL("libfftw3.so.3")
# name: (extension, libsndfile's format, quality of Ogg or compression of MP3, 128 kbit/s being two thirds of its scale from 320 to 32)
FORMS = {"wav16": ("wav", 0x010002, None), "wav24": ("wav", 0x010003, None), "float": ("wav", 0x010006, None),
         "flac": ("flac", 0x170003, None), "ogg4": ("ogg", 0x200060, 0.4), "ogg6": ("ogg", 0x200060, 0.6),
         "ogg8": ("ogg", 0x200060, 0.8), "mp3": ("mp3", 0x230082, 2.0 / 3.0)}


class _Info(ctypes.Structure):
    _fields_ = [("frames", ctypes.c_int64), ("samplerate", ctypes.c_int), ("channels", ctypes.c_int), ("format", ctypes.c_int),
                ("sections", ctypes.c_int), ("seekable", ctypes.c_int)]


class _Conversion(ctypes.Structure):
    _fields_ = [("data_in", ctypes.c_void_p), ("data_out", ctypes.c_void_p), ("input_frames", ctypes.c_long),
                ("output_frames", ctypes.c_long), ("input_frames_used", ctypes.c_long), ("output_frames_gen", ctypes.c_long),
                ("end_of_input", ctypes.c_int), ("src_ratio", ctypes.c_double)]


_sndfile.sf_open.restype = ctypes.c_void_p
for _name in ("sf_readf_double", "sf_write_double"):
    getattr(_sndfile, _name).restype = ctypes.c_int64
    getattr(_sndfile, _name).argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64]
_sndfile.sf_command.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_int]
_sndfile.sf_close.argtypes = [ctypes.c_void_p]
_fftw.fftw_plan_dft_r2c_1d.restype = ctypes.c_void_p
_fftw.fftw_execute.argtypes = _fftw.fftw_destroy_plan.argtypes = [ctypes.c_void_p]


def read(path):
    """(samples of the first channel, rate in Hz)."""
    info = _Info()
    handle = _sndfile.sf_open(str(path).encode(), 0x10, ctypes.byref(info))
    if not handle:
        raise OSError(f"{path}: not readable")
    block, samples = (ctypes.c_double * (4096 * info.channels))(), []
    while n := _sndfile.sf_readf_double(handle, block, 4096):
        samples += block[:n * info.channels:info.channels]
    _sndfile.sf_close(handle)
    return samples, info.samplerate


def write(stem, samples, rate_hz, form):
    """The path of stem with the extension of form (of FORMS); scaled down to full scale where it is above."""
    extension, code, quality = FORMS[form]
    path = pathlib.Path(f"{stem}.{extension}")
    scale = 0.98 / max(0.98, max(map(abs, samples)))
    data = array.array("d", (scale * x for x in samples))
    info = _Info(0, int(rate_hz), 1, code, 0, 0)
    handle = _sndfile.sf_open(str(path).encode(), 0x20, ctypes.byref(info))
    if not handle:
        raise OSError(f"{path}: not writable")
    if quality is not None:
        value = ctypes.c_double(quality)
        if form == "mp3":
            _sndfile.sf_command(handle, 0x1305, ctypes.byref(ctypes.c_int(0)), 4)  # constant bit rate
            _sndfile.sf_command(handle, 0x1301, ctypes.byref(value), 8)
        else:
            _sndfile.sf_command(handle, 0x1300, ctypes.byref(value), 8)
    address, _ = data.buffer_info()
    for start in range(0, len(data), 4096):
        _sndfile.sf_write_double(handle, address + 8 * start, min(4096, len(data) - start))
    _sndfile.sf_close(handle)
    return path


def resampled(samples, rate_hz, new_hz):
    data = array.array("f", samples)
    length = int(len(samples) * new_hz / rate_hz)
    out = array.array("f", bytes(4 * (length + 16)))
    conversion = _Conversion(data.buffer_info()[0], out.buffer_info()[0], len(data), len(out), 0, 0, 1, new_hz / rate_hz)
    if _samplerate.src_simple(ctypes.byref(conversion), 0, 1):
        raise OSError("libsamplerate failed")
    return list(out[:conversion.output_frames_gen])


class Spectrum:
    """Powers of the transform under a Blackman-Harris window (side lobes below -92 dB, main lobe 4 cells either side)."""

    def __init__(self, samples, rate_hz):
        n = len(samples)
        real, out = (ctypes.c_double * n)(), (ctypes.c_double * (2 * (n // 2 + 1)))()
        plan = _fftw.fftw_plan_dft_r2c_1d(n, real, out, 64)
        step = 2 * math.pi / n
        real[:] = [x * (0.35875 - 0.48829 * math.cos(step * i) + 0.14128 * math.cos(2 * step * i) - 0.01168 * math.cos(3 * step * i))
                   for i, x in enumerate(samples)]
        _fftw.fftw_execute(plan)
        _fftw.fftw_destroy_plan(plan)
        self.power = [re * re + im * im for re, im in zip(out[0::2], out[1::2])]
        self.cell_hz = rate_hz / n

    def loudest(self, low_hz, high_hz):
        """Frequency of the highest bin in band."""
        low, high = int(low_hz / self.cell_hz) + 1, min(int(high_hz / self.cell_hz), len(self.power) - 1)
        return self.cell_hz * max(range(low, high), key=self.power.__getitem__)

    def stands_db(self, frequency_hz):
        """How far a peak within 3 cells of the frequency stands above the median of the 60 cells beyond the main lobe on either side."""
        k = round(frequency_hz / self.cell_hz)
        peak = max(self.power[max(0, k - 3):k + 4], default=0.0)
        around = sorted(self.power[max(0, k - 70):max(0, k - 10)] + self.power[k + 11:k + 71])
        return 10 * math.log10(max(peak, 1e-300) / max(around[len(around) // 2] / math.log(2), 1e-300)) if around else 0.0


class Maker:
    """Rings, noises and other sounds at rate_hz from a random.Random."""

    def __init__(self, source, rate_hz):
        self.random, self.rate_hz = source, rate_hz

    def noise(self, seconds, slope=0.0):
        """Gaussian noise of rms 1, its power falling as f^-slope for slope 0 (white), 1 (pink, within 1 dB) and 2 (brown, above 20 Hz); -2 is blue's
        steeper kin, differenced white."""
        n = int(seconds * self.rate_hz)
        white = [self.random.gauss(0, 1) for _ in range(n)]
        if slope == 1:  # P. Kellet's three poles
            b0 = b1 = b2 = 0.0
            for i, w in enumerate(white):
                b0, b1, b2 = 0.99765 * b0 + 0.0990460 * w, 0.96300 * b1 + 0.2965164 * w, 0.57000 * b2 + 1.0526913 * w
                white[i] = b0 + b1 + b2 + 0.1848 * w
        elif slope == 2:
            keep = math.exp(-2 * math.pi * 20 / self.rate_hz)
            white = list(itertools.accumulate(white, lambda y, w: keep * y + w))
        elif slope == -2:
            white = list(map(operator.sub, white[1:], white))
        rms = math.sqrt(sum(x * x for x in white) / max(1, len(white)))
        return [x / rms for x in white]

    def exponential(self, seconds, frequency_hz, decay_per_s, amplitude, phase_rad):
        n = int(seconds * self.rate_hz)
        pole = complex(-decay_per_s, 2 * math.pi * frequency_hz) / self.rate_hz
        step = complex(math.exp(pole.real) * math.cos(pole.imag), math.exp(pole.real) * math.sin(pole.imag))
        start = complex(amplitude * math.cos(phase_rad), amplitude * math.sin(phase_rad))
        return [z.real for z in itertools.accumulate(itertools.repeat(step, max(0, n - 1)), operator.mul, initial=start)]

    def glide(self, seconds, frequency_of, amplitude_of):
        """cos of the integral of frequency_of(t) [Hz], times amplitude_of(t)."""
        phase, out, step = 0.0, [], 2 * math.pi / self.rate_hz
        for i in range(int(seconds * self.rate_hz)):
            t = i / self.rate_hz
            phase += step * frequency_of(t)
            out.append(amplitude_of(t) * math.cos(phase))
        return out


def added(base, other, start=0, gain=1.0):
    """base with gain times other added from sample start on; in place."""
    end = min(len(base), start + len(other))
    base[start:end] = [x + gain * y for x, y in zip(base[start:end], other)]
    return base
