#!/usr/bin/env bash
# A whole UMBmark by curl: the service drives its robot, solves, and accepts. Usage: bash 05_fleet.sh [URL] [SIDE] [RUNS]
set -euo pipefail
url=${1:-http://127.0.0.1:8080} side=${2:-4} runs=${3:-5}
json=(-sS --fail-with-body -H 'Content-Type: application/json')
[ -z "${OMNIMATE_KEY:-}" ] || json+=(-H "Authorization: Bearer $OMNIMATE_KEY")

session=$url$(curl "${json[@]}" -D - -o /dev/null -H "Idempotency-Key: $(date +%s%N)" "$url/v1/umbmark/sessions" \
    -d "{\"how\": \"drive\", \"side\": $side, \"runs\": $runs}" | tr -d '\r' | sed -n 's/^location: //Ip')
until curl "${json[@]}" "$session" | grep -q '"state":"collecting"'; do
    curl "${json[@]}" "$session" | grep -o '"detail":"[^"]*"'
    curl "${json[@]}" "$session" | grep -Eq '"state":"(interrupted|aborted|failed)"' && exit 1
    sleep 1
done
curl "${json[@]}" -X POST "$session/solve" -d '{"method": "exact"}'
echo
curl "${json[@]}" -X POST -H 'If-Match: *' "$session/accept" -d '{}' -o /dev/null
curl "${json[@]}" "$url/v1/vehicles/omnimate/exports/ros2"
