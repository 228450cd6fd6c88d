"""The seeds' figures, remade from our own data with the exact solutions beside them."""
import csv
import io
import math
import os

import matplotlib.pyplot as plt
import numpy as np

import figures
import programs
from page import table, text
from run_errors import parse_run
from report_plan import Case
from task_pool import Kept, Task, key_of, run_tasks, stamp_of

# The seeds' three simulators, and colours.
THREE = {'volume-verlet': ('volume (ours)', '#2367d1'), 'point-verlet': ('point', '#7d8894'),
         'ode_exact': ('analytic (ODE)', '#e07b1a')}
HOUSNER = 0.25   # ω after over before each impact of a rigid plastic cube on its edge
INERTIA, SIZE, GRAVITY = 2 / 3, 2.0, 9.8  # of the tilted cube: m a²/6 [kg m²], edge [m], [m/s²]
GEAR = (('2 N/mm at 1 kHz', '2000', '1000'), ('20 N/mm at 10 kHz', '20000', '10000'))
BREAKDOWN = ('a_cube', 'b_stack', 'c_bin', 'd_two_hands')


class Data:
    """Outputs of the programs that the figures are made of, run in parallel and kept."""

    def __init__(self, options, run_program, seed_program, root):
        self.options, self.run_program, self.seed_program, self.root = options, run_program, seed_program, root
        self.stamp = stamp_of(run_program, seed_program)
        self.tasks = {}

    def need(self, name, *command):
        self.tasks[name] = Task(key_of(self.stamp, *command[1:]), tuple(command), 120, 1.0)

    def need_run(self, name, scene, method, step, *more):
        self.need(name, self.run_program, scene, method, repr(step), '0', '0', '--budget', '0', *more)

    def fetch(self):
        kept = Kept(os.path.join(self.options.output, 'runs'))
        done = run_tasks(list(self.tasks.values()), kept, "seeds' figures", self.options.scheduler, self.options.workers)
        self.results = {name: done[task.key] for name, task in self.tasks.items()}

    def run(self, name, method):
        return parse_run(Case('', method, 0, 0, 0), self.results[name])

    def rows(self, name):
        result = self.results[name]
        return [] if result['failure'] else list(csv.reader(io.StringIO(result['output'])))


def request(data, quick):
    data.need('lambda', data.seed_program, 'lambda', os.path.join(data.root, 'urdf', 'devices', 'spidar_4.yaml'))
    for method in THREE:
        data.need_run(('tilt', method), 'tilt', method, 1e-3, '--seconds', '2', '--samples', '400')
        data.need_run(('top', method), 'top', method, 1e-3, '--seconds', '2', '--samples', '200')
        data.need_run(('stick_slip', method), 'stick_slip', method, 1e-3, '--seconds', '2', '--samples', '400')
        for count in block_counts(quick):
            data.need_run(('blocks', method, count), f'stack{count}', method, 0.25e-3, '--seconds', '0.1')
    for scene, samples in (('top', '200'), ('stick_slip', '400')):
        data.need(('exact', scene), data.run_program, scene, 'exact', '--seconds', '2', '--samples', samples)
    for scene in BREAKDOWN:
        data.need(('stages', scene), data.seed_program, 'stages', os.path.join(data.root, 'urdf', 'scenes', scene + '.urdf'),
                  '1' if quick else '5')
    for label, stiffness, rate in GEAR:
        data.need(('gear', label), data.seed_program, 'gear', os.path.join(data.root, 'urdf', 'scenes', 'gear.urdf'), stiffness,
                  rate)


def block_counts(quick):
    return (1, 2, 4, 8, 15) if quick else (1, 2, 3, 4, 5, 6, 8, 10, 12, 15)


def lambda_figure(data, folder):
    rows = data.rows('lambda')[1:]
    if not rows:
        return ''
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6))
    shades = {'0': '#b53030', '0.1': '#e07b1a', '0.2': '#1c9c84', '0.3': '#2367d1', '1': '#5b3fb0'}
    for value, colour in shades.items():
        own = [row for row in rows if row[0] == value]
        position = [float(row[1]) for row in own]
        tensions = np.array([[float(t) for t in row[3:]] for row in own])
        left.plot(position, tensions[:, 0], color=colour, label=f'λ = {value}')
        left.plot(position, tensions[:, 1], color=colour, lw=0.6)
        right.plot(position, [float(row[2]) for row in own], color=colour, label=f'λ = {value}')
    left.set_title('tensions of two strings [N] (SPIDAR with 4 strings)')
    right.set_title('presented force [N]; 5 N are asked for')
    for axes in (left, right):
        axes.set_xlabel('position along the diagonal [m]')
    right.legend()
    figure.tight_layout()
    return figures.save(figure, folder, 'seed-lambda')


def blocks_figure(data, quick, folder):
    figure, axes = plt.subplots(figsize=(5.2, 3.6))
    for method, (label, colour) in THREE.items():
        points = []
        for count in block_counts(quick):
            run = data.run(('blocks', method, count), method)
            if run.status == 'ok' and run.steps:
                points.append((count, 1e6 * run.cpu * 0.1 / run.steps))  # 0.1 s were simulated
        if points:
            axes.loglog(*zip(*points), marker='o', ms=3.5, color=colour, label=label)
    axes.set_xlabel('stacked cubes')
    axes.set_title('CPU time of a step [µs]')
    axes.legend()
    figure.tight_layout()
    return figures.save(figure, folder, 'seed-blocks')


def rigid_plastic(end, samples):
    """Exact angular momentum about the mass centre of the rigid cube that rocks to rest: time, L [N m s]. Between impacts
    it turns about the edge it stands on; each impact leaves a quarter of ω (Housner)."""
    substeps = 200
    h = end / samples / substeps
    angle, speed, side, times, momenta = 0.1, 0.0, 1.0, [0.0], [0.0]
    factor = 1.5 * GRAVITY / (math.sqrt(2) * SIZE)

    def pull(a):
        return -factor * math.cos(math.pi / 4 + a)
    for step in range(1, samples * substeps + 1):
        if speed != 0 or angle > 0:
            half = speed + h / 2 * pull(angle)  # velocity Verlet
            angle += h * half
            speed = half + h / 2 * pull(angle)
            if angle <= 0:
                angle, speed, side = 0.0, -HOUSNER * speed, -side
                if speed < 1e-4:
                    speed = 0.0
        if step % substeps == 0:
            times.append(step * h)
            momenta.append(-INERTIA * speed * side)
    return np.array(times), np.array(momenta)


def tilt_figure(data, folder):
    figure, axes = plt.subplots(figsize=(6.4, 3.6))
    for method, (label, colour) in THREE.items():
        run = data.run(('tilt', method), method)
        if run.trajectory is not None:
            axes.plot(run.trajectory.time, INERTIA * run.trajectory.twist[:, 0, 1], color=colour, lw=1, label=label)
    times, momenta = rigid_plastic(2, 400)
    axes.plot(times, momenta, color=figures.INK, lw=0.8, ls='--', label='exact: rigid, plastic')
    axes.set_xlabel('time [s]')
    axes.set_title('angular momentum of the tilted cube [N m s]; 2 m, 1 kg, 0.1 rad, k = 4e4 N/m³')
    axes.legend()
    figure.tight_layout()
    return figures.save(figure, folder, 'seed-tilt')


def axis_of(trajectory):
    """x and y of a body's z axis."""
    w, x, y, z = trajectory.pose[:, 0, 3:].T
    return 2 * (x * z + w * y), 2 * (y * z - w * x)


def top_figure(data, folder):
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.9))
    exact = parse_run(Case('', 'exact', 0, 0, 0), data.results[('exact', 'top')]).trajectory
    curves = [('exact', figures.INK, exact)] + [
        (label, colour, data.run(('top', method), method).trajectory) for method, (label, colour) in THREE.items()]
    for label, colour, trajectory in curves:
        if trajectory is None:
            continue
        x, y = axis_of(trajectory)
        style = {'color': colour, 'label': label, 'lw': 0.9, 'ls': '--' if label == 'exact' else '-'}
        left.plot(x, y, **style)
        right.plot(trajectory.time, np.arctan2(np.hypot(x, y), np.sqrt(np.maximum(0, 1 - x * x - y * y))), **style)
    left.set_aspect('equal')
    left.set_title('path of the axis of the top (x, y of its unit vector), 2 s')
    right.set_title('tilt [rad]')
    right.set_xlabel('time [s]')
    right.legend()
    figure.tight_layout()
    return figures.save(figure, folder, 'seed-top')


def stick_slip_figure(data, folder):
    figure, panels = plt.subplots(1, 4, figsize=(11.5, 3.2), sharey=True)
    exact = parse_run(Case('', 'exact', 0, 0, 0), data.results[('exact', 'stick_slip')]).trajectory
    curves = [('exact', exact)] + [(label, data.run(('stick_slip', method), method).trajectory)
                                   for method, (label, _) in THREE.items()]
    for axes, (label, trajectory) in zip(panels, curves):
        axes.set_title(label)
        axes.set_xlabel('time [s]')
        if trajectory is None:
            axes.text(0.5, 0.5, 'did not run', transform=axes.transAxes, ha='center', color=figures.FAILED)
            continue
        axes.plot(trajectory.time, -trajectory.hands[:, 0, 3], color='#2367d1', lw=1, label='spring force [N]')
        axes.plot(trajectory.time, 50 * trajectory.pose[:, 0, 0], color='#e07b1a', lw=1, label='position [2 cm]')
    panels[0].legend()
    figure.tight_layout()
    return figures.save(figure, folder, 'seed-stickslip')


def outline(points):
    """Convex hull of (x, y) points, counter-clockwise (Andrew's monotone chain)."""
    def half(ordered):
        chain = []
        for p in ordered:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1]) -
                                      (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]
    ordered = sorted(set(points))
    return half(ordered) + half(ordered[::-1])


def gear_figure(data, folder):
    figure, panels = plt.subplots(1, 2, figsize=(8.6, 4.6), sharex=True, sharey=True)
    for axes, (label, _, _) in zip(panels, GEAR):
        path = []
        for row in data.rows(('gear', label)):
            if row[0] == 'shape':
                flat = [1e3 * float(v) for v in row[1:]]
                axes.fill(*zip(*outline(list(zip(flat[::2], flat[1::2])))), color=figures.FAINT, lw=0)
            else:
                path.append([1e3 * float(v) for v in row[:2]])
        if path:
            axes.plot(*zip(*path), color='#2367d1', lw=0.9)
            middle = np.mean(path, axis=0)
            axes.set_xlim(middle[0] - 36, middle[0] + 36)
            axes.set_ylim(middle[1] - 36, middle[1] + 36)
        axes.set_title(label)
        axes.set_aspect('equal')
        axes.set_xlabel('x [mm]')
    figure.tight_layout()
    return figures.save(figure, folder, 'seed-gear')


def stage_figure(data, folder):
    names = ('detection: boxes', 'detection: pairs apart', 'volume analysis', 'integration of forces', 'motion of bodies')
    colours = ('#9ab8e6', '#5b8bd6', '#2367d1', '#e07b1a', '#7d8894')
    rows, labels = [], []
    for scene, letter in zip(BREAKDOWN, 'ABCD'):
        found = data.rows(('stages', scene))
        if found:
            rows.append([float(v) for v in found[-1][1:]])
            labels.append(f'{letter}: {scene}')
    if not rows:
        return '', ''
    values = np.array(rows)[:, 3:]
    figure, axes = plt.subplots(figsize=(7.4, 3.2))
    left = np.zeros(len(rows))
    for k, (name, colour) in enumerate(zip(names, colours)):
        axes.barh(labels, values[:, k], left=left, color=colour, label=name, height=0.6)
        left += values[:, k]
    axes.invert_yaxis()
    axes.set_xlabel('time of a step [µs], the clock included')
    axes.legend(ncol=3, loc='upper center', bbox_to_anchor=(0.45, -0.22))
    axes.grid(axis='y', visible=False)
    figure.tight_layout()
    shares = [[label] + [100 * v / sum(row) for v in row] + [float(sum(row)), rows[i][1], rows[i][2]]
              for i, (label, row) in enumerate(zip(labels, values))]
    heads = ['scene'] + [name + ' [%]' for name in names] + ['step [µs]', 'pairs', 'contacts']
    return figures.save(figure, folder, 'seed-stages'), table(heads, shares)


def body_of(data, quick, folder):
    def captioned(svg, caption):
        return svg.replace('</figure>', f'<figcaption>{text(caption)}</figcaption></figure>')
    stages, shares = stage_figure(data, folder)
    return ''.join([
        captioned(lambda_figure(data, folder), 'Hasegawa and Sato, slides 9 to 12: the larger λ, the smoother the tensions where the '
                  'force can no longer be presented in full, and the less of it is presented.'),
        captioned(blocks_figure(data, quick, folder), 'Slide 38: three methods at 0.25 ms.'),
        captioned(tilt_figure(data, folder), 'Slide 39. A resolved compliant contact loses less at an impact than the rigid plastic '
                  'limit; the point model never comes to rest.'),
        captioned(top_figure(data, folder), 'Slide 40.'),
        captioned(stick_slip_figure(data, folder), 'Slide 42: mu0 0.265, mu 0.160. The analytic simulator knows one coefficient.'),
        captioned(gear_figure(data, folder), 'Slide 16: path of a ball of 2 mm (its centre) that a hand leads along the teeth of a gear '
                  'with mu 0.5, pressing with 2 N. What 10 kHz buys is stiffness: the path keeps the teeth\'s shape.'),
        captioned(stages, 'Slide 44: where the time of a step goes, scenes A to D.'), shares])


def sections(options, folder):
    """[(title, anchor, html)]; empty when the programs are not there."""
    run_program, seed_program = (programs.find(options.programs, name) for name in ('report_run', 'seed_data'))
    if not run_program or not seed_program:
        return []
    data = Data(options, run_program, seed_program, programs.ROOT)
    request(data, options.quick)
    data.fetch()
    return [("The seeds' figures", 'seeds', body_of(data, options.quick, folder))]
