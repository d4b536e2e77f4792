// Numbers that are the same wherever the scripts run: mulberry32.
export class Random {
  #state;

  constructor(seed) {
    this.#state = seed;
  }

  // In [0, 1), 32 bits of it.
  unit() {
    this.#state = (this.#state + 0x6d2b79f5) | 0;
    let t = Math.imul(this.#state ^ (this.#state >>> 15), 1 | this.#state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  }

  // An integer from low to high, both included.
  integer(low, high) {
    return low + Math.floor(this.unit() * (high - low + 1));
  }

  chance(probability) {
    return this.unit() < probability;
  }

  pick(choices) {
    return choices[this.integer(0, choices.length - 1)];
  }

  real(low, high) {
    return low + this.unit() * (high - low);
  }

  shuffled(values) {
    const result = [...values];
    for (let i = result.length - 1; i > 0; --i) {
      const j = this.integer(0, i);
      [result[i], result[j]] = [result[j], result[i]];
    }
    return result;
  }

  // Three numbers. A scene keeps to one kind of `coordinates`, so that each kind of tie comes about:
  //   'lattice'  small integers: exact ties
  //   'sphere'   permuted and mirrored, so equally far from the origin, in sums of another order
  //   'close'    apart in the last bits of a double: near-ties
  //   'any'
  point(coordinates) {
    switch (coordinates) {
      case 'lattice':
        return [this.integer(-2, 2), this.integer(-2, 2), this.integer(-2, 2)];
      case 'sphere':
        return this.shuffled([0.1, 0.7, 1.3]).map((x) => (this.chance(0.5) ? x : -x));
      case 'close':
        return [0.1, 0.7, 1.3].map((x) => x * (1 + this.integer(-2, 2) * 2 ** -52));
      default:
        return [this.real(-5, 5), this.real(-5, 5), this.real(-5, 5)];
    }
  }

  coordinates() {
    return this.pick(['lattice', 'lattice', 'sphere', 'close', 'any']);
  }
}
