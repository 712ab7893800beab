"""Time left of a campaign, from the speed of the runs that are on."""


def remaining_s(running, waiting_weights, jobs):
    """When the last case will end if every waiting one takes the first place that becomes free, in their order.

    @param running          jobs with remaining_s and weight_per_s, None as long as they have not told their speed
    @param waiting_weights  costs of the cases that have not begun
    @return seconds, or None if no job has told its speed
    """
    told = [job for job in running if job.weight_per_s]
    if not told:
        return None
    weight_per_s = sum(job.weight_per_s for job in told) / len(told)
    places = [
        job.remaining_s if job.weight_per_s else job.entry.weight * (1.0 - job.share) / weight_per_s for job in running
    ]
    places += [0.0] * (jobs - len(places))
    for weight in waiting_weights:
        place = places.index(min(places))
        places[place] += weight / weight_per_s
    return max(places)
