"""VMAF by libvmaf, as FFmpeg has it: Li et al., Toward a practical perceptual video quality metric, Netflix 2016."""

import json
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from metrics import Clip
from swimlab.scoring.peer import Peer, PeerError, displayed

NAMES = ("test", "reference")
"""FFmpeg's libvmaf takes the distorted video first."""


def score(test: Clip, reference: Clip) -> dict[str, float]:
    """VMAF v0.6.1 of each frame, 0..100: mean and worst; of luma of 8-bit codes, by the ffmpeg of imageio-ffmpeg."""
    import imageio_ffmpeg  # an extra

    height, width = test.shape
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{test.fps:g}"]
    words = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", "-nostdin"]
    with TemporaryDirectory() as folder:
        for name, clip in zip(NAMES, (test, reference), strict=True):
            with (Path(folder) / name).open("wb") as file:
                for frame in range(clip.count):
                    file.write(np.rint(255 * displayed(clip, frame)).astype(np.uint8).tobytes())
            words += [*raw, "-i", name]
        planes = "[0:v]format=yuv444p[a];[1:v]format=yuv444p[b]"
        words += ["-lavfi", f"{planes};[a][b]libvmaf=log_fmt=json:log_path=vmaf.json", "-f", "null", "-"]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, errors="replace", check=False)
        log = Path(folder) / "vmaf.json"
        if done.returncode or not log.exists():
            raise PeerError(f"--peers vmaf: {words[0]} failed: {done.stderr.strip()[-300:] or 'it has no libvmaf'}")
        pooled = json.loads(log.read_text(encoding="utf-8"))["pooled_metrics"]["vmaf"]
    return {"vmaf.mean": float(pooled["mean"]), "vmaf.worst": float(pooled["min"])}


PEER = Peer(
    name="vmaf",
    summary="VMAF a frame, 0..100, higher is better",
    source="Li et al. 2016, libvmaf in the ffmpeg of imageio-ffmpeg",
    extra="vmaf",
    score=score,
)
