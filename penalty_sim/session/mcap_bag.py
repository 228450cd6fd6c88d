#!/usr/bin/python3
"""Turns a bag into an MCAP file, and an MCAP file of ours into a bag: mcap_bag.py FROM TO, by the ending of TO.

Messages, stamps, types and publishers stay as they are. A bag that is made for ./run replay, report or export holds what those
read alone: the recording, statistics of ticks, states of devices.
"""
import os
import sys

import genpy
import rosbag

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import mcap_file  # noqa: E402

READ_BACK = ('haptic_msgs/SessionInfo', 'haptic_msgs/TickRecord', 'haptic_msgs/LoopEvent', 'haptic_msgs/TickStatistics',
             'haptic_msgs/DeviceState')


class AsItIs:
    """Stands in for a message class: the bag takes text and sum from the header of the connection."""
    def __init__(self, md5sum, text):
        self._md5sum, self._full_text = md5sum, text


def unreadable(source, error):
    """One line for a rosbag.ROSBagException: why the bag cannot be read, and what to do."""
    if isinstance(error, rosbag.ROSBagUnindexedException):
        return f'{source}: is truncated: it has no index: mend it by: rosbag reindex {source}'
    if str(error).startswith(source):
        return str(error)
    return f'{source}: cannot be read as a bag: {error}'


def opened(source):
    """A bag to read. Raises rosbag.ROSBagException for every file that is none: rosbag takes the first line of any file for text."""
    try:
        return rosbag.Bag(source)
    except UnicodeDecodeError as error:
        raise rosbag.ROSBagException('it does not begin as a bag does') from error


def to_mcap(source, target):
    """Writes all of a bag; the number of messages."""
    count = 0
    with opened(source) as bag, open(target, 'wb') as file:
        writer, channels = mcap_file.Writer(file, 'haptics mcap_bag'), {}
        for topic, (kind, data, md5sum, _, _), at, header in bag.read_messages(raw=True, return_connection_header=True):
            header = {key: value.decode() if isinstance(value, bytes) else value for key, value in header.items()}
            key = (topic, md5sum, header.get('callerid', ''))
            if key not in channels:
                definition = header['message_definition']
                channels[key] = (writer.channel(topic, kind, definition, md5sum=md5sum, callerid=header.get('callerid', ''),
                                                latching=header.get('latching', '0')), mcap_file.has_header(definition))
            channel, has_header = channels[key]
            writer.message(channel, at.to_nsec(), mcap_file.stamp_of(data) or at.to_nsec() if has_header else at.to_nsec(), data)
            count += 1
        writer.close()
    return count


def to_bag(source, target):
    """Writes what is read back of an MCAP file; the number of messages."""
    count = 0
    with rosbag.Bag(target, 'w') as bag:
        for topic, kind, definition, about, at, data in mcap_file.messages(source, lambda _, kind: kind in READ_BACK):
            header = {'topic': topic, 'type': kind, 'md5sum': about.get('md5sum', ''), 'message_definition': definition,
                      'callerid': about.get('callerid', ''), 'latching': about.get('latching', '0')}
            stamp = genpy.Time(at // 1_000_000_000, at % 1_000_000_000)
            as_it_is = AsItIs(header['md5sum'], definition)
            bag.write(topic, (kind, data, header['md5sum'], as_it_is), stamp, raw=True, connection_header=header)
            count += 1
    return count


def main():
    source, target = sys.argv[1:]
    try:
        (to_mcap if target.endswith('.mcap') else to_bag)(source, target)
    except mcap_file.Damaged as error:
        sys.exit(str(error))
    except rosbag.ROSBagException as error:
        sys.exit(unreadable(source, error))
    except OSError as error:
        sys.exit(f'{error.filename or target}: {error.strerror}')


if __name__ == '__main__':
    main()
