"""Train a learner of another package from presses alone.

Run: MINARI_DATASETS_PATH=FOLDER python train_from_presses.py

scikit-learn's ridge regression learns what participants think of a placement: the feedback credited to a
step, from the features of what was done. Environmental rewards are not used.
"""

import minari
import numpy as np
from sklearn.linear_model import Ridge
from sklearn.model_selection import GroupKFold, cross_val_predict

data = minari.load_dataset("arl/tetris-20x10-v0")
features, feedback, game = [], [], []
for episode in data.iterate_episodes():
    judged = episode.infos["n_presses"][1:] > 0  # infos[t + 1] belongs to actions[t]
    features.append(episode.infos["feedback_features"][1:][judged])
    feedback.append(episode.infos["feedback"][1:][judged])
    game += [episode.id] * int(judged.sum())

X, y = np.concatenate(features), np.concatenate(feedback)
predicted = cross_val_predict(Ridge(alpha=1.0), X, y, groups=game, cv=GroupKFold(n_splits=5))
agreed = np.mean(np.sign(predicted) == np.sign(y))
print(f"{len(y)} judged placements in {len(set(game))} games; ", end="")
print(f"sign of unseen games' feedback predicted: {agreed:.0%}")
