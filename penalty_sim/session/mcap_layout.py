"""A layout for Lichtblick and Foxglove beside an MCAP file: the scene in 3-D, forces, pose, contacts, times of ticks."""
import json
import os
import sys

import mcap_file


def devices_of(path):
    """Namespaces of devices, from the topics of DeviceState."""
    found = set()
    for topic, kind, *_ in mcap_file.messages(path, lambda _, kind: kind == 'haptic_msgs/DeviceState'):
        found.add(topic.rsplit('/', 1)[0])
    return sorted(found)


def plot(title, paths):
    return {'title': title, 'paths': [{'value': value, 'label': label, 'enabled': True, 'timestampMethod': 'headerStamp'}
                                      for label, value in paths],
            'showLegend': True, 'showXAxisLabels': True, 'showYAxisLabels': True, 'legendDisplay': 'floating', 'isSynced': True,
            'xAxisVal': 'timestamp'}


def layout(devices):
    """Lichtblick's and Foxglove's form. Fixed frame `world`; topics are those of `./run demo`."""
    topics = ['/markers'] + [device + '/markers' for device in devices]
    view = {'layers': {'grid': {'layerId': 'foxglove.Grid', 'instanceId': 'grid', 'visible': True, 'size': 1, 'divisions': 20}},
            'cameraState': {'perspective': True, 'distance': 1.0, 'phi': 65, 'thetaOffset': 45, 'target': [0, 0, 0],
                            'targetOffset': [0, 0, 0], 'fovy': 45, 'near': 0.01, 'far': 100},
            'followMode': 'follow-none', 'followTf': 'world', 'scene': {'transforms': {'visible': False}},
            'topics': {topic: {'visible': True} for topic in topics}}
    several = len(devices) > 1

    def of(topic, field, axes='xyz'):
        return [((device.strip('/') + ' ' if several else '') + axis, f'{device}/{topic}.{field}.{axis}')
                for device in devices for axis in axes]

    panels = {
        '3D!scene': view,
        'Plot!force': plot('Force on the hand [N]', of('wrench', 'wrench.force')),
        'Plot!pose': plot('Position of the grip [m]', of('pose', 'pose.position')),
        'Plot!ticks': plot('Time of a tick [µs]', [(name, '/tick_statistics.' + name)
                                                   for name in ('tick_us_p50', 'tick_us_p99', 'lateness_us_p99')]),
        'Plot!error': plot('Error of the step [m]', [('position', '/live_report.position_error')]),
        'StateTransitions!state': {'isSynced': True, 'paths': [
            {'value': device + '/state.state', 'label': device.strip('/'), 'timestampMethod': 'receiveTime'} for device in devices]},
        'RawMessages!contacts': {'topicPath': '/contacts', 'diffEnabled': False, 'diffMethod': 'custom', 'showFullMessageForDiff': False},
    }

    def split(direction, first, second, share):
        return {'direction': direction, 'first': first, 'second': second, 'splitPercentage': share}

    right = split('column', 'Plot!force', split('column', 'Plot!pose', split('column', 'Plot!ticks', 'Plot!error', 50), 33), 25)
    left = split('column', '3D!scene', split('row', 'StateTransitions!state', 'RawMessages!contacts', 60), 70)
    return {'configById': panels, 'globalVariables': {}, 'userNodes': {}, 'playbackConfig': {'speed': 1},
            'layout': split('row', left, right, 58)}


def write_beside(path):
    """Writes PATH without .mcap + .layout.json; its path."""
    target = os.path.splitext(path)[0] + '.layout.json'
    with open(target, 'w', encoding='utf-8') as file:
        json.dump(layout(devices_of(path)), file, indent=1, ensure_ascii=False)
        file.write('\n')
    return target


if __name__ == '__main__':
    print(write_beside(sys.argv[1]))
