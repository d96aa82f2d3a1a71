// The robot on the floor, to scale: wheels and wheelbase as the vehicle has them, the linkage as it stands.
// Width of the wheels and outline of the decks are drawn after them; nobody measures those.

const DECK = 1.25; // of the wheelbase: length of a deck
const TREAD = 0.28; // of the diameter: width of a wheel

/** Draw both trucks, or the only one; `poses` {a, b} in metres and radians. */
export function drawRobot(context, viewport, vehicle, poses, colours) {
  if (vehicle.trucks.b && poses.b) drawLink(context, viewport, poses, colours);
  for (const name of ["b", "a"]) {
    if (vehicle.trucks[name] && poses[name]) drawTruck(context, viewport, vehicle.trucks[name], poses[name], name, colours);
  }
}

function drawTruck(context, viewport, truck, pose, name, colours) {
  const scale = viewport.scale;
  const [x, y] = viewport.at(pose.x, pose.y);
  const wide = truck.wheelbase;
  context.save();
  context.translate(x, y);
  context.rotate(-pose.theta);
  context.scale(scale, -scale); // metres from here on, y to the left
  context.lineWidth = 1.5 / scale;
  context.strokeStyle = colours.ink;
  context.fillStyle = colours.deck;
  context.beginPath();
  context.roundRect(-DECK * wide / 2, -0.42 * wide, DECK * wide, 0.84 * wide, 0.09 * wide);
  context.fill();
  context.stroke();
  context.fillStyle = colours.ink;
  for (const [side, diameter] of [[1, truck.wheel_diameter_left], [-1, truck.wheel_diameter_right]]) {
    const tread = TREAD * diameter;
    context.beginPath();
    context.roundRect(-diameter / 2, side * wide / 2 - tread / 2, diameter, tread, tread / 3);
    context.fill();
  }
  context.beginPath(); // which way is forward
  context.moveTo(0.5 * wide, 0.16 * wide);
  context.lineTo(0.58 * wide, 0);
  context.lineTo(0.5 * wide, -0.16 * wide);
  context.stroke();
  context.beginPath();
  context.arc(0, 0, 0.05 * wide, 0, 2 * Math.PI);
  context.fillStyle = colours.link;
  context.fill();
  context.restore();
  if (scale * wide < 26) return;
  context.fillStyle = colours.ink;
  context.font = "600 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  const back = 0.36 * wide * scale;
  context.fillText(name, x - back * Math.cos(pose.theta), y + back * Math.sin(pose.theta));
}

/** The compliant linkage: a bar at either truck and the slider between them. */
function drawLink(context, viewport, { a, b }, colours) {
  const [ax, ay] = viewport.at(a.x, a.y);
  const [bx, by] = viewport.at(b.x, b.y);
  const part = (share) => [bx + share * (ax - bx), by + share * (ay - by)];
  const line = (from, to, width, colour) => {
    context.beginPath();
    context.moveTo(...part(from));
    context.lineTo(...part(to));
    context.lineWidth = width;
    context.strokeStyle = colour;
    context.stroke();
  };
  const thick = Math.min(9, Math.max(3, 0.045 * viewport.scale));
  line(0, 1, thick / 2, colours.link);
  line(0.38, 0.62, thick * 1.6, colours.link);
  line(0.41, 0.59, thick * 0.8, colours.paper);
}

/** Where truck b stands by the linkage, C (16); joint angle is truck heading minus link heading. */
export function follower(a, joints) {
  const heading = a.theta - joints.a;
  return {
    x: a.x - joints.length * Math.cos(heading),
    y: a.y - joints.length * Math.sin(heading),
    theta: heading + joints.b,
  };
}
