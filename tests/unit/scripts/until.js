// pictures are decoded in real time, while the browser's own clock runs ahead: some work between two looks
const until = async test => {
  for (let look = 0; look < 500 && !test(); look++) {
    for (let work = 0; work < 2e4; work++) Math.random();
    await new Promise(done => setTimeout(done, 10));
  }
};
