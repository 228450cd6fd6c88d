"""What the 3-D view of a session's page is drawn from: poses in steps that keep every point of a body within POSE_ERROR, patches, meshes.

Each series is a row of whole numbers, kept as second differences in bytes (differences of patches: first), deflated.
"""
import base64
import zlib

import numpy as np

POSITION_STEP = 5e-6     # of poses [m]: at most 4.3 µm off
TURN_ERROR = 4e-6        # that a turned body's farthest point is off, at most [m]
POSE_ERROR = 1e-5        # both together stay below [m]
OPENING_STEP = 1e-5     # of grips with 7 degrees of freedom [m]
PATCH_STEPS = {'at': 5e-5, 'normal': 0.01, 'force': 0.01, 'radius': 5e-5, 'pressure': 200.0}  # [m], [1], [N], [m], [Pa]
MOST_PATCH_ROWS = 60000  # of a session; more are thinned out
MOST_BYTES = 700_000     # of poses, before base64; longer sessions have a frame every few ticks
TRIANGLES = 50000        # of all meshes; finer ones are coarsened
PLANES = 4               # bytes of a whole number


def planes(levels, order):
    """Whole numbers as bytes: differences of that order, the low bytes first."""
    out = np.asarray(levels, dtype=np.int64)
    for _ in range(order):
        out = np.diff(out, prepend=0)
    zigzag = ((out << 1) ^ (out >> 63)).astype('<u4')  # small ones of either sign have high bytes of zero
    return zigzag.view(np.uint8).reshape(-1, PLANES).T.tobytes()


def back(raw, count, order):
    """What `planes` has packed."""
    zigzag = np.frombuffer(raw, np.uint8, PLANES * count).reshape(PLANES, count).T.copy().view('<u4').ravel().astype(np.int64)
    out = (zigzag >> 1) ^ -(zigzag & 1)
    for _ in range(order):
        out = np.cumsum(out)
    return out


def continuous(quaternions):
    """The same rotations, each with the sign nearest to the one before it."""
    signs = np.where(np.einsum('ij,ij->i', quaternions[1:], quaternions[:-1]) < 0, -1.0, 1.0)
    return quaternions * np.concatenate(([1.0], np.cumprod(signs)))[:, None]


def rotated(q, points):
    """Points, n × 3, turned by quaternions x, y, z, w of the same number or one."""
    u, w = q[..., :3], q[..., 3:]
    return points + 2 * np.cross(u, np.cross(u, points) + w * points)


def reach(visual, view):
    """Distance of the farthest point of a visual from its link's origin [m]."""
    size, pose = np.array(visual['size']), np.array(visual['pose'])
    far = np.linalg.norm(view.meshes[visual['mesh']][0], axis=1).max() if visual['shape'] == 'mesh' else np.linalg.norm(size) / 2
    return float(np.linalg.norm(pose[:3]) + far)


class Poses:
    """Tracks of poses at every `stride`-th tick."""

    def __init__(self, ticks, stride):
        self.rows = np.arange(0, ticks, stride)
        self.bytes, self.tracks, self.worst = [], [], 0.0

    def add(self, table, name, names, radius):
        """`radius`: of the farthest point that is drawn [m]. Where there is no pose, the last one stays."""
        columns = np.stack([np.asarray(table[f'{name}.{names[0]}_{axis}'])[self.rows] for axis in 'xyz']
                           + [np.asarray(table[f'{name}.{names[1]}_{axis}'])[self.rows] for axis in 'xyzw'], axis=1)
        valid = np.isfinite(columns).all(axis=1)
        if not valid.any():
            return None
        columns = columns[np.maximum.accumulate(np.where(valid, np.arange(len(valid)), np.argmax(valid)))]
        position, turn = columns[:, :3], continuous(columns[:, 3:])
        turn_step = 0.5 * TURN_ERROR / max(radius, 1e-4)  # |δq| <= step of four parts half off each; the angle is twice that
        levels = [np.rint(position / POSITION_STEP), np.rint(turn / turn_step)]
        self.worst = max(self.worst, self.error(position, turn, levels[0] * POSITION_STEP, levels[1] * turn_step, radius))
        for column in np.concatenate([part.T for part in levels]):
            self.bytes.append(planes(column, 2))
        self.bytes.append(planes(valid, 1))
        self.tracks.append({'step': POSITION_STEP, 'turn': turn_step})
        return len(self.tracks) - 1

    def add_opening(self, table, device):
        """Of a grip that opens: the step of its series; 0: it does not."""
        opening = np.asarray(table[device['name'] + '.opening'])[self.rows]
        if not any(any(string['per_opening']) for string in device['strings']) or not np.isfinite(opening).any():
            return 0
        self.bytes.append(planes(np.rint(np.nan_to_num(opening) / OPENING_STEP), 2))
        return OPENING_STEP

    @staticmethod
    def error(position, turn, position_back, turn_back, radius):
        """How far the farthest point is off, at most [m]."""
        turn_back = turn_back / np.linalg.norm(turn_back, axis=1, keepdims=True)
        chord = np.minimum(np.linalg.norm(turn - turn_back, axis=1), np.sqrt(2))
        way = 2 * radius * np.sin(2 * np.arcsin(chord / 2))  # unit quaternions at chord c are 4 asin(c / 2) of rotation apart
        return float((np.linalg.norm(position - position_back, axis=1) + way).max())


def patch_tracks(patches, rows_at_most):
    """Patches thinned to every n-th sampled tick; runs in which the same patch of a pair lasts. (rows in order, runs, ticks per sample)"""
    ticks = patches['tick'].astype(np.int64)
    times = np.unique(ticks)
    gap = int(np.diff(times).min()) if len(times) > 1 else 1
    every = gap * max(1, -(-len(patches) // rows_at_most))
    patches = patches[ticks % every == 0]
    if not len(patches):
        return patches, [], every
    ticks = patches['tick'].astype(np.int64)
    pair = patches['a'].astype(np.int64) * 65536 + patches['b'].astype(np.int64)
    order = np.lexsort((np.arange(len(patches)), pair, ticks))
    patches, ticks, pair = patches[order], ticks[order], pair[order]
    fresh = np.concatenate(([True], (np.diff(ticks) != 0) | (np.diff(pair) != 0)))
    place = np.arange(len(patches)) - np.maximum.accumulate(np.where(fresh, np.arange(len(patches)), 0))  # of the patch in its pair
    order = np.lexsort((ticks, place, pair))
    patches, ticks, key = patches[order], ticks[order], (pair * 256 + place)[order]
    starts = np.flatnonzero(np.concatenate(([True], (np.diff(key) != 0) | (np.diff(ticks) != every))))
    ends = np.append(starts[1:], len(patches))
    runs = [[int(ticks[a] // every), int(b - a), int(patches['a'][a]), int(patches['b'][a])] for a, b in zip(starts, ends)]
    return patches, runs, every


def coarse(points, triangles, most):
    """A mesh of no more than about `most` triangles: vertices of a cell become one. (points, triangles, largest shift of a vertex)"""
    if len(triangles) <= most:
        return points, triangles, 0.0
    low, size = points.min(axis=0), np.ptp(points, axis=0).max()
    shift = 0.0
    for cells in (192, 160, 128, 96, 80, 64, 48, 40, 32, 24, 16, 12, 8):
        cell = np.floor((points - low) / (size / cells)).astype(np.int64)
        _, index, counts = np.unique(cell @ (1, 1024, 1024 ** 2), return_inverse=True, return_counts=True)
        centres = np.stack([np.bincount(index, points[:, axis]) for axis in range(3)], axis=1) / counts[:, None]
        left = index[triangles]
        left = left[(left[:, 0] != left[:, 1]) & (left[:, 1] != left[:, 2]) & (left[:, 2] != left[:, 0])]
        left = np.unique(left, axis=0)
        shift = float(np.linalg.norm(points - centres[index], axis=1).max())
        if len(left) <= most:
            break
    return centres, left, shift


def packed_meshes(meshes):
    """(bytes, what they are, largest error [m])"""
    out, about, worst = [], [], 0.0
    total = sum(len(triangles) for _, triangles in meshes)
    for points, triangles in meshes:
        share = max(200, TRIANGLES * len(triangles) // max(total, 1))
        points, triangles, shift = coarse(points.astype(float), triangles.astype(np.int64), share)
        low = points.min(axis=0)
        step = float(np.ptp(points, axis=0).max() / 65535) or 1.0
        levels = np.rint((points - low) / step)
        worst = max(worst, shift + np.sqrt(3) / 2 * step)
        out += [planes(levels[:, axis], 1) for axis in range(3)] + [planes(triangles.ravel(), 1)]
        about.append({'vertices': len(points), 'triangles': len(triangles), 'low': [float(x) for x in low], 'step': step})
    return out, about, worst


def short(values, digits=6):
    return [float(f'{value:.{digits}g}') for value in values]


def pack(session):
    """(JSON-able dict, base64 text) of a session."""
    view, table = session.view, session.table
    about, ticks, stride = view.about, len(session.table), 1
    radius = {}
    for visual in about['visuals']:
        radius[visual['link']] = max(radius.get(visual['link'], 0.0), reach(visual, view))
    while True:
        poses, links, grips = Poses(ticks, stride), [], []
        for number, link in enumerate(about['links']):
            links.append({'name': link['name'], 'track': None, 'pose': short(link['pose'], 9)})
            if link['moves']:
                links[-1]['track'] = poses.add(table, 'body.' + link['name'], ('position', 'orientation'), radius.get(number, 0.01))
        for device in about['devices']:
            far = max([device['grip_radius']] + [np.linalg.norm(string['knot']) for string in device['strings']])
            grips.append(poses.add(table, device['name'], ('position', 'orientation'), far))
        openings = [poses.add_opening(table, device) for device in about['devices']]
        size = len(zlib.compress(b''.join(poses.bytes), 6))
        if size <= MOST_BYTES or len(poses.rows) < 100:
            break
        stride = max(stride + 1, int(stride * size / MOST_BYTES + 0.999))
    patches, runs, every = patch_tracks(view.patches, MOST_PATCH_ROWS)
    area = np.maximum(patches['area'], 0)
    columns = {'at': patches['at'], 'normal': patches['normal'], 'force': patches['force'], 'radius': np.sqrt(area / np.pi)[:, None],
               'pressure': np.divide(patches['normal_force'], area, out=np.zeros(len(patches)), where=area > 0)[:, None].clip(0, 1e8)}
    patch_bytes = [planes(np.rint(column / PATCH_STEPS[name]), 1) for name, columns_of in columns.items() for column in columns_of.T]
    patch_bytes.append(planes(patches['sticking'], 1))
    mesh_bytes, meshes, mesh_error = packed_meshes(view.meshes)
    data = {'period': stride / session.info['rate'], 'frames': len(poses.rows), 'stride': stride, 'tracks': poses.tracks,
            'links': links, 'visuals': [{'link': v['link'], 'shape': v['shape'], 'mesh': v['mesh'], 'size': short(v['size']),
                                         'pose': short(v['pose']), 'colour': short(v['colour'], 3)} for v in about['visuals']],
            'devices': [{'name': device['name'], 'track': grip, 'radius': device['grip_radius'], 'opening': opening,
                         'strings': [{'exit': short(s['exit']), 'knot': short(s['knot']), 'travel': short(s['per_opening'])}
                                     for s in device['strings']]}
                        for device, grip, opening in zip(about['devices'], grips, openings)],
            'bases': [{'at': base['tick'] / session.info['rate'], 'hand': base['hand'], 'scale': base['scale'],
                       'pose': short(base['pose'], 9)} for base in about['bases']],
            'patches': {'count': len(patches), 'runs': runs, 'period': every / session.info['rate'], 'steps': PATCH_STEPS},
            'meshes': meshes, 'poseError': poses.worst, 'meshError': mesh_error}
    return data, base64.b64encode(zlib.compress(b''.join(poses.bytes + patch_bytes + mesh_bytes), 9)).decode()
