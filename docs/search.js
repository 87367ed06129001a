// How the search weighs what it has found: as Sphinx does, with the pages for contributors behind those for users.
const INSIDE = /^(decisions|explanation.(tour|where|code_flow|promises)|reference.(conformance|performance|compiled))/;
var Scorer = {
  score: ([page, , , , score]) => (INSIDE.test(page) ? score / 10 : score),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 0, 1: -1, 2: -5 }, // a name of the API is found after a title, and before running text
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
