"""Images made by rule. Each repeats without a seam unless its function says otherwise. Rows run down, as in files."""
import numpy as np
from PIL import Image


def save(path, pixels):
    """Numbers from 0 to 1, of one channel, three or four."""
    Image.fromarray(np.uint8(np.clip(pixels, 0, 1) * 255 + 0.5)).save(path)


def save_heights(path, heights):
    """In 16 bits: steps of 8 would tilt a leaf by 6 degrees between two pixels."""
    Image.fromarray(np.uint16(np.clip(heights, 0, 1) * 65535 + 0.5)).save(path)


def cloud(height, width, slope, seed, stretch=1.0, finest=np.inf):
    """Fractal noise of mean 0 and deviation 1, by its spectrum: 1/f^slope. Above 1, stretch draws it out along rows.
    finest: the frequency from which the noise fades. A surface without one gets steeper the closer one looks."""
    rng = np.random.default_rng(seed)
    y, x = np.fft.fftfreq(height)[:, None] * height, np.fft.rfftfreq(width)[None, :] * width
    f = np.hypot(y, x * stretch)
    f[0, 0] = 1
    spectrum = np.fft.rfft2(rng.standard_normal((height, width))) / f**slope * np.exp(-((f / finest) ** 2))
    spectrum[0, 0] = 0
    noise = np.fft.irfft2(spectrum, (height, width))
    return noise / noise.std()


def blend(a, b, part):
    """From colour a to colour b."""
    return np.asarray(a) + (np.asarray(b) - np.asarray(a)) * part[..., None]


def ramp(x, low, high):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def grid(height, width):
    """u and v of the pixels' centres."""
    return np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)


def wood(path, planks=4, size=1024):
    """Planks along the rows: colour, roughness, and the height of grain and joints."""
    u, v = grid(size, 2 * size)
    plank = np.floor(v * planks).astype(int)
    across = v * planks - plank
    rng = np.random.default_rng(5)
    tone, shift = rng.uniform(-1, 1, planks)[plank], rng.integers(0, 2 * size, planks)
    drawn = cloud(size, 2 * size, 1.9, 1, 14)
    fibre = cloud(size, 2 * size, 0.75, 2, 60)
    for p in range(planks):
        drawn[plank[:, 0] == p] = np.roll(drawn[plank[:, 0] == p], shift[p], 1)
    rings = 9 * across + 1.6 * drawn + 5 * tone
    late = ramp(rings % 1, 0.25, 0.95) * (1 - ramp(rings % 1, 0.95, 1))
    dark = np.clip(0.5 * late + 0.13 * fibre + 0.14 * tone + 0.25, 0, 1)
    joint = ramp(np.minimum(across, 1 - across), 0.004, 0.016)
    color = blend([0.62, 0.42, 0.25], [0.30, 0.165, 0.085], dark) * (0.25 + 0.75 * joint)[..., None]
    save(path("wood.png"), color)
    save(path("wood_roughness.png"), 0.38 + 0.12 * dark + 0.05 * fibre + 0.3 * (1 - joint))
    grain = cloud(size, 2 * size, 0.75, 2, 60, 250)
    save_heights(path("wood_height.png"), (0.75 - 0.12 * late + 0.035 * grain) * joint)


def plaster(path, size=1024):
    rough, broad = cloud(size, size, 1.35, 3, finest=150), cloud(size, size, 2.2, 4)
    save(path("plaster.png"), blend([0.60, 0.57, 0.52], [0.47, 0.44, 0.41], np.clip(0.5 + 0.2 * broad, 0, 1)))
    save_heights(path("plaster_height.png"), 0.5 + 0.11 * rough + 0.06 * broad)


def weave(path, threads=64, size=1024):
    """Linen: colour, and a normal map of threads that pass over and under each other."""
    u, v = grid(size, size)
    slub = cloud(size, size, 1.0, 6, 8) + cloud(size, size, 1.0, 7, 8).T
    x, y = u * threads + 0.03 * slub, v * threads + 0.03 * slub.T
    over = (np.floor(x) + np.floor(y)) % 2
    hump = np.where(over > 0, np.sin(np.pi * (x % 1)) ** 0.5 * (0.6 + 0.4 * np.sin(np.pi * (y % 1))),
                    np.sin(np.pi * (y % 1)) ** 0.5 * (0.6 + 0.4 * np.sin(np.pi * (x % 1))))
    height = hump + 0.08 * slub
    dx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2
    dy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2
    n = np.stack([-2.2 * dx, 2.2 * dy, np.ones_like(dx)], -1)
    save(path("linen_normal.png"), n / np.linalg.norm(n, axis=-1, keepdims=True) / 2 + 0.5)
    stripe = ramp(np.abs(v - 0.5), 0.42, 0.425) * (1 - ramp(np.abs(v - 0.5), 0.455, 0.46))
    color = blend([0.83, 0.79, 0.70], [0.22, 0.30, 0.42], stripe)
    save(path("linen.png"), color * (0.72 + 0.28 * hump + 0.03 * slub)[..., None])


def glaze(path, height=1024, width=2048):
    """The vase's: cobalt blue painted on white. v runs from the lip to the foot."""
    u, v = grid(height, width)
    wave = cloud(height, width, 1.6, 8)
    hand = v + 0.0022 * wave

    def band(at, half):
        return 1 - ramp(np.abs(hand - at), half, half + 0.003)

    def petals(count, top, bottom, turn=0.0):
        x = np.abs((u * count + turn) % 1 - 0.5) + 0.008 * wave
        t = np.clip((hand - top) / (bottom - top), 0, 1)
        inside = 0.44 * np.sin(np.pi * t) ** 0.75 * (1 - 0.45 * t)
        ring = (1 - ramp(np.abs(x - inside), 0.02, 0.035)) * (t > 0.004) * (t < 0.996)
        heart = (1 - ramp(x, 0.5 * inside, 0.5 * inside + 0.02)) * ramp(t, 0.25, 0.3) * (1 - ramp(t, 0.8, 0.85))
        return np.maximum(ring, 0.62 * heart)

    def dots(count, at, radius):
        x = (u * count % 1 - 0.5) / count * width / height * 0.62
        return 1 - ramp(np.hypot(x, hand - at), radius, radius + 0.003)

    ink = np.max([band(0.045, 0.010), band(0.075, 0.003), dots(48, 0.105, 0.008), band(0.135, 0.004),
                  petals(12, 0.16, 0.34), petals(12, 0.34, 0.62, 0.5), petals(24, 0.60, 0.70), band(0.725, 0.004),
                  dots(36, 0.755, 0.011), band(0.785, 0.004), petals(16, 0.80, 0.93), band(0.955, 0.014)], 0)
    ink = np.clip(ink * (0.86 + 0.1 * wave), 0, 1)
    save(path("glaze.png"), blend([0.90, 0.89, 0.85], [0.10, 0.17, 0.47], ink))


def peel(path, size=512):
    """An orange's: colour, and the height of its pores. It has a seam where u is 0."""
    u, v = grid(size, 2 * size)
    rng = np.random.default_rng(9)
    y, x = np.fft.fftfreq(size)[:, None] * size, np.fft.rfftfreq(2 * size)[None, :] * 2 * size
    ring = np.exp(-(((np.hypot(y, x / 2) - 55) / 14) ** 2))
    pores = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((size, 2 * size))) * ring, (size, 2 * size))
    pores = ramp(pores / pores.std(), 0.4, 1.8)
    broad = cloud(size, 2 * size, 2.0, 10)
    color = blend([0.95, 0.52, 0.08], [0.93, 0.62, 0.14], np.clip(0.5 + 0.25 * broad, 0, 1))
    green = ramp(np.abs(v - 0.5), 0.43, 0.5)
    save(path("peel.png"), blend(color, [0.72, 0.60, 0.12], 0.7 * green) * (1 - 0.10 * pores)[..., None])
    save_heights(path("peel_height.png"), 0.85 - 0.6 * pores + 0.04 * broad)


def leaf(path, height=1024, width=512):
    """A leaf whose stalk is at the lower edge; alpha is its shape. It does not repeat."""
    u, v = grid(height, width)
    x, t = (u - 0.5) * 2, 1 - v
    rib = np.abs(x)
    tooth = (t * 26 + rib * 5) % 1
    shape = np.clip(np.sin(np.pi * np.clip(t * 1.02, 0, 1)), 0, 1) ** 0.72 * (1.12 - 0.42 * t)
    shape *= 0.865 + 0.055 * tooth
    blade = rib < shape
    stalk = (rib < 0.028) & (t < 0.2)
    side = np.abs((t * 8.5 - rib * 2.6) % 1 - 0.5)
    vein = np.maximum(1 - ramp(rib, 0.012, 0.035), 0.65 * (1 - ramp(side, 0.02, 0.06)))
    rim = ramp(rib / np.maximum(shape, 1e-3), 0.75, 1)
    tone = np.clip(0.45 + 0.16 * cloud(height, width, 1.8, 11) + 0.3 * rim, 0, 1)
    color = blend(blend([0.17, 0.33, 0.10], [0.33, 0.44, 0.14], tone), [0.52, 0.62, 0.30], 0.8 * vein)
    save(path("leaf.png"), np.dstack([color, np.float64(blade | stalk)]))
    save_heights(path("leaf_height.png"), 0.5 - 0.35 * vein + 0.05 * cloud(height, width, 1.2, 12, finest=40))


LETTERS = {"F": [[(0, 0), (0, 2)], [(0, 2), (1, 2)], [(0, 1.1), (0.8, 1.1)]],
           "A": [[(0, 0), (0.6, 2)], [(0.6, 2), (1.2, 0)], [(0.22, 0.7), (0.98, 0.7)]],
           "T": [[(0.6, 0), (0.6, 2)], [(0, 2), (1.2, 2)]],
           "H": [[(0, 0), (0, 2)], [(1.1, 0), (1.1, 2)], [(0, 1.05), (1.1, 1.05)]],
           "O": [[(0.6 + 0.62 * np.cos(a), 1 + np.sin(a)), (0.6 + 0.62 * np.cos(b), 1 + np.sin(b))]
                 for a, b in zip(np.arange(0, 6.2, 0.2618), np.arange(0.2618, 6.5, 0.2618))],
           "M": [[(0, 0), (0, 2)], [(0, 2), (0.65, 0.7)], [(0.65, 0.7), (1.3, 2)], [(1.3, 2), (1.3, 0)]]}


def distance(x, y, a, b):
    """To the segment from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = np.clip(((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy), 0, 1)
    return np.hypot(x - a[0] - t * dx, y - a[1] - t * dy)


def cover(path, height=1024, width=768):
    """The front of a book bound in cloth, with gilt: colour, metallic, roughness and height. It does not repeat."""
    u, v = grid(height, width)
    x, y = u * 12, (1 - v) * 16
    gilt = np.full(u.shape, np.inf)
    for inset, wide in ((0.9, 0.07), (1.2, 0.025)):
        edge = np.maximum(np.abs(x - 6) - 6, np.abs(y - 8) - 8) + inset
        gilt = np.minimum(gilt, np.abs(edge) - wide)
    at = 6 - 0.5 * (5 * 1.4 + 1)
    for letter in "FATHOM":
        for a, b in LETTERS[letter]:
            ends = [(at + 0.76 * p[0], 11.6 + 0.76 * p[1]) for p in (a, b)]
            gilt = np.minimum(gilt, distance(x, y, *ends) - 0.1)
        at += 1.4
    turn, far = np.arctan2(y - 6, x - 6), np.hypot(x - 6, y - 6)
    star = 0.5 - np.abs((turn * 2 / np.pi) % 1 - 0.5)
    gilt = np.minimum(gilt, far * (0.4 + 4.5 * star) - 0.95)
    gilt = np.minimum(gilt, np.abs(far - 2.9) - 0.05)
    gold = 1 - ramp(gilt, -0.02, 0.03)
    thread = 0.5 + 0.25 * np.sin(2 * np.pi * u * 150) + 0.25 * np.sin(2 * np.pi * v * 200)
    worn = ramp(cloud(height, width, 1.7, 13), 1.5, 2.6)
    gold *= 1 - 0.8 * worn
    save(path("cover.png"), blend(blend([0.27, 0.085, 0.075], [0.36, 0.13, 0.11], thread), [0.98, 0.80, 0.45], gold))
    save(path("cover_metal.png"), np.dstack([0 * gold, 0.75 - 0.47 * gold + 0.1 * worn, gold]))
    save_heights(path("cover_height.png"), 0.6 + 0.25 * thread * (1 - gold) - 0.3 * gold)


def pages(path, size=512):
    """The edges of a book's pages, along the rows."""
    rng = np.random.default_rng(14)
    lines = np.repeat(rng.uniform(0.55, 1, (size, 1)), size, 1) * (1 + 0.03 * cloud(size, size, 1.2, 15, 20))
    save(path("pages.png"), blend([0.55, 0.48, 0.36], [0.88, 0.83, 0.70], np.clip(lines, 0, 1)))


def brushed(path, size=1024):
    """Grooves along the rows, for roughness."""
    save(path("brushed.png"), 0.5 + 0.12 * cloud(size, size, 0.5, 16, 80))


def all_images(path):
    for make in (wood, plaster, weave, glaze, peel, leaf, cover, pages, brushed):
        make(path)
